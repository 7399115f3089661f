#include "roomfix/connect/line_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <utility>

namespace roomfix {
namespace {

constexpr std::size_t most_bytes_waiting = 4'000'000;  // bytes

std::string cure_of(int problem) {
    if (problem == ENOSPC || problem == EDQUOT || problem == EFBIG) return "make room there, or choose another disk";
    if (problem == EROFS) return "the disk is read-only: mount it for writing, or choose another one";
    if (problem == EACCES || problem == EPERM) return "check the folder's permissions";
    if (problem == ENOENT) return "its folder is gone: was it moved or deleted?";
    return "check the disk";
}

Error cannot_write(const std::filesystem::path& file, int problem) {
    return Error{fmt::format("{}: cannot be written ({}): {}", file.string(), std::strerror(problem), cure_of(problem))};
}

/// 0, or the errno of what went wrong.
int write_all(int descriptor, const char* bytes, std::size_t size) {
    while (size > 0) {
        const ssize_t written = ::write(descriptor, bytes, size);
        if (written < 0 && errno == EINTR) continue;
        if (written < 0) return errno;
        bytes += written;
        size -= static_cast<std::size_t>(written);
    }
    return 0;
}

int write_file_of(const std::filesystem::path& file, const char* bytes, std::size_t size) {
    const int descriptor = ::open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
    if (descriptor < 0) return errno;
    int problem = write_all(descriptor, bytes, size);
    if (::close(descriptor) != 0 && problem == 0) problem = errno;
    return problem;
}

}  // namespace

Result<void> write_whole(const std::filesystem::path& file, std::string_view text) {
    const std::filesystem::path beside = file.string() + ".part";
    int problem = write_file_of(beside, text.data(), text.size());
    if (problem == 0 && std::rename(beside.c_str(), file.c_str()) != 0) problem = errno;
    if (problem == 0) return {};
    ::unlink(beside.c_str());
    return cannot_write(file, problem);
}

Result<void> write_whole(const std::filesystem::path& file, std::span<const std::uint8_t> bytes) {
    return write_whole(file, std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
}

Result<LineFile> LineFile::create(const std::filesystem::path& file, std::string_view first_lines) {
    if (auto written = write_whole(file, first_lines); !written) return written.error();
    const int descriptor = ::open(file.c_str(), O_WRONLY | O_APPEND | O_CLOEXEC);
    if (descriptor < 0) return cannot_write(file, errno);
    return LineFile(file, descriptor, static_cast<std::int64_t>(first_lines.size()));
}

LineFile::~LineFile() {
    if (descriptor_ >= 0) ::close(descriptor_);
}

LineFile::LineFile(LineFile&& other) noexcept
    : path_(std::move(other.path_)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      bytes_(other.bytes_),
      waiting_(std::move(other.waiting_)),
      lost_lines_(other.lost_lines_) {}

LineFile& LineFile::operator=(LineFile&& other) noexcept {
    std::swap(path_, other.path_);
    std::swap(descriptor_, other.descriptor_);
    std::swap(bytes_, other.bytes_);
    std::swap(waiting_, other.waiting_);
    std::swap(lost_lines_, other.lost_lines_);
    return *this;
}

void LineFile::add(std::string_view line) {
    if (waiting_.size() + line.size() > most_bytes_waiting) {
        ++lost_lines_;
        return;
    }
    waiting_ += line;
}

long LineFile::waiting_lines() const { return static_cast<long>(std::count(waiting_.begin(), waiting_.end(), '\n')); }

Result<void> LineFile::flush() {
    if (waiting_.empty()) return {};
    const int problem = write_all(descriptor_, waiting_.data(), waiting_.size());
    if (problem != 0) {
        // Half a line would spoil the next one as well. A file can be made shorter on a full disk, too.
        if (::ftruncate(descriptor_, bytes_) != 0) return cannot_write(path_, errno);
        return cannot_write(path_, problem);
    }
    bytes_ += static_cast<std::int64_t>(waiting_.size());
    waiting_.clear();
    return {};
}

}  // namespace roomfix
