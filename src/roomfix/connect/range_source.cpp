#include "roomfix/connect/range_source.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

#include "roomfix/connect/sensed_lines.hpp"

namespace roomfix {

Result<RangeBatch> load_ranges(const std::string& file, const Site& site, int robot, int receiver) {
    const auto sensed = read_sensed(file);
    if (!sensed) return Error{fmt::format("{}: no ranges can be read from there: check the name", file)};
    RangeReader reader(site, robot, receiver);
    RangeBatch batch;
    reader.feed(sensed->text, std::nullopt, batch);
    reader.finish(std::nullopt, batch);
    if (!sensed->note.empty()) batch.problems.push_back(sensed->note);
    for (std::string& problem : batch.problems) problem = file + ": " + problem;
    if (reader.lines() > 0 && reader.bad_lines() == reader.lines()) return Error{batch.problems[0]};
    const auto earlier = [](const auto& a, const auto& b) { return a.time < b.time; };
    std::stable_sort(batch.ranges.begin(), batch.ranges.end(), earlier);
    std::stable_sort(batch.differences.begin(), batch.differences.end(), earlier);
    return batch;
}

Result<SerialLine> SerialLine::open(const std::string& device) {
    const int file = ::open(device.c_str(), O_RDONLY | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
    if (file < 0) {
        return Error{fmt::format("{}: cannot be opened ({}): is the listener plugged in, and may you read it (group dialout)?", device, std::strerror(errno))};
    }
    termios settings;
    if (tcgetattr(file, &settings) == 0) {
        cfmakeraw(&settings);
        settings.c_cflag |= CLOCAL | CREAD;
        cfsetispeed(&settings, B115200);
        cfsetospeed(&settings, B115200);
        tcsetattr(file, TCSANOW, &settings);
    }
    return SerialLine(file);
}

SerialLine::~SerialLine() {
    if (file_ >= 0) ::close(file_);
}

SerialLine::SerialLine(SerialLine&& other) noexcept : file_(std::exchange(other.file_, -1)) {}

bool SerialLine::read(double seconds, std::string& bytes) {
    pollfd waiting{file_, POLLIN, 0};
    const int ready = ::poll(&waiting, 1, static_cast<int>(seconds * 1000));
    if (ready == 0 || (ready < 0 && errno == EINTR)) return true;
    if (ready < 0) return false;
    std::array<char, 1024> buffer;
    const ssize_t count = ::read(file_, buffer.data(), buffer.size());
    if (count > 0) bytes.append(buffer.data(), static_cast<std::size_t>(count));
    return count > 0 || (count < 0 && (errno == EAGAIN || errno == EINTR));
}

}  // namespace roomfix
