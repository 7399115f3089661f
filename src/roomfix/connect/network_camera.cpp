#include "roomfix/connect/network_camera.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "roomfix/connect/packet_reader.hpp"
#include "roomfix/connect/shown_address.hpp"
#include "roomfix/imaging/load_luma.hpp"

namespace roomfix {
namespace {

using Clock = std::chrono::steady_clock;

constexpr auto patience_at_first = std::chrono::seconds(10);  // video starts with the first picture that needs none before it
constexpr auto patience_later = std::chrono::seconds(4);
constexpr std::size_t most_in_decoder = 32;
constexpr std::size_t most_pictures_waiting = 200;  // coded pictures that need those before them: some seconds

/// A coded picture and when it was taken.
struct Taken {
    StreamPacket packet;
    StampedTime stamp;
};

class NetworkCamera final : public FrameSource {
public:
    explicit NetworkCamera(std::shared_ptr<StreamClock> clock) : clock_(std::move(clock)) {}
    ~NetworkCamera() override {
        interrupt();
        if (thread_.joinable()) thread_.join();
    }
    NetworkCamera(const NetworkCamera&) = delete;
    NetworkCamera& operator=(const NetworkCamera&) = delete;

    Result<void> open(const std::string& address, const std::atomic<bool>& stop);

    Result<bool> advance(SourceFrame& frame) override;
    Result<void> decode(SourceFrame& frame) override;
    void keep_files() override { keeps_files_ = true; }
    bool live() const override { return true; }
    std::int64_t count() const override { return -1; }
    std::string note() const override {
        const std::lock_guard lock(mutex_);
        return clock_->told();
    }
    std::int64_t passed_over() const override {
        const std::lock_guard lock(mutex_);
        return passed_over_;
    }
    void interrupt() override {
        const std::lock_guard lock(mutex_);
        closed_ = true;
        changed_.notify_all();
    }

private:
    void read();
    void keep(Taken picture);
    std::optional<Taken> newest(std::deque<Taken> pictures);

    std::shared_ptr<StreamClock> clock_;
    std::atomic<bool> closed_{false};
    std::unique_ptr<PacketReader> reader_;
    std::unique_ptr<PictureDecoder> decoder_;  // null: every picture is a JPEG
    bool keeps_files_ = false;
    Taken given_;
    std::int64_t number_ = 0;                                    // of packets that were decoded
    std::deque<std::pair<std::int64_t, StampedTime>> decoding_;  // packets whose pictures are not ready yet

    mutable std::mutex mutex_;  // for what follows, and the clock
    std::condition_variable changed_;
    std::deque<Taken> waiting_;
    std::string failure_;  // not empty: nothing more comes
    bool gap_ = false;     // pictures were thrown away: those that come are of no use before one that needs none before it
    std::int64_t passed_over_ = 0;
    std::int64_t frames_ = 0;
    std::thread thread_;
};

Result<void> NetworkCamera::open(const std::string& address, const std::atomic<bool>& stop) {
    auto reader = open_packet_reader(address, {stop, closed_});
    if (!reader) return reader.error();
    auto decoder = (*reader)->decoder();
    if (!decoder) return Error{fmt::format("{}: {}", shown_address(address), decoder.error().message)};
    reader_ = std::move(*reader);
    decoder_ = std::move(*decoder);
    clock_->restart();
    thread_ = std::thread([this] { read(); });
    return {};
}

/// The thread that takes what comes, so that nothing ever waits in the network.
void NetworkCamera::read() {
    while (!closed_) {
        auto packet = reader_->read();
        const std::lock_guard lock(mutex_);
        if (packet) {
            const StampedTime stamp = clock_->stamp({packet->system, packet->steady, packet->media, packet->wall});
            keep({std::move(*packet), stamp});
        } else {
            failure_ = packet.error().message;
        }
        changed_.notify_all();
        if (!failure_.empty()) return;
    }
}

/// The mutex is held.
void NetworkCamera::keep(Taken picture) {
    const bool late = decoder_ ? waiting_.size() >= most_pictures_waiting : !waiting_.empty();
    if (late) {
        passed_over_ += static_cast<std::int64_t>(waiting_.size());
        waiting_.clear();
        gap_ = decoder_ != nullptr;
    }
    if (gap_ && !picture.packet.key) {
        ++passed_over_;
        return;
    }
    gap_ = false;
    waiting_.push_back(std::move(picture));
}

/// Decodes all of them; the last picture that is ready, if one is.
std::optional<Taken> NetworkCamera::newest(std::deque<Taken> pictures) {
    if (!decoder_) return std::move(pictures.back());
    std::optional<Taken> last;
    std::int64_t ready = 0;
    for (const Taken& picture : pictures) {
        decoding_.emplace_back(++number_, picture.stamp);
        if (decoding_.size() > most_in_decoder) decoding_.pop_front();
        (void)decoder_->feed(picture.packet, number_);  // what is damaged is missed as a picture that does not come
        while (const auto number = decoder_->take()) {
            const auto of_it = std::find_if(decoding_.begin(), decoding_.end(), [&](const auto& d) { return d.first == *number; });
            if (of_it == decoding_.end()) continue;
            last = Taken{{}, of_it->second};
            decoding_.erase(of_it);
            ++ready;
        }
    }
    if (ready > 1) {
        const std::lock_guard lock(mutex_);
        passed_over_ += ready - 1;
    }
    return last;
}

Result<bool> NetworkCamera::advance(SourceFrame& frame) {
    const auto until = Clock::now() + (frames_ == 0 ? patience_at_first : patience_later);
    std::optional<Taken> picture;
    while (!picture) {
        std::deque<Taken> pictures;
        {
            std::unique_lock lock(mutex_);
            changed_.wait_until(lock, until, [this] { return closed_ || !waiting_.empty() || !failure_.empty(); });
            if (closed_) return false;
            if (waiting_.empty()) return Error{failure_.empty() ? "what comes from the camera makes no picture: restart it" : failure_};
            pictures.swap(waiting_);
        }
        picture = newest(std::move(pictures));
        if (!picture && Clock::now() > until) return Error{"what comes from the camera makes no picture: set it to H.264 or MJPEG"};
    }
    given_ = std::move(*picture);
    frame.time = given_.stamp.time;
    frame.time_error = given_.stamp.error;
    frame.name = std::to_string(++frames_);
    return true;
}

Result<void> NetworkCamera::decode(SourceFrame& frame) {
    if (!decoder_) {
        auto decoded = decode_picture(given_.packet.bytes, frame.image, frame.colour);
        frame.encoded = std::move(given_.packet.bytes);
        return decoded;
    }
    frame.encoded.clear();
    frame.file = {};
    const auto picture = decoder_->picture();
    if (!picture) return picture.error();
    if (keeps_files_) frame.file = yuv_file(*picture);
    luma_from_yuv(*picture, frame.image);
    colour_from_yuv(*picture, frame.colour);
    return {};
}

}  // namespace

bool is_network_address(const std::string& source) { return source.find("://") != std::string::npos; }

Result<std::unique_ptr<FrameSource>> open_network_camera(const std::string& address, std::shared_ptr<StreamClock> clock, const std::atomic<bool>& stop) {
    auto camera = std::make_unique<NetworkCamera>(std::move(clock));
    if (auto opened = camera->open(address, stop); !opened) return opened.error();
    return std::unique_ptr<FrameSource>(std::move(camera));
}

}  // namespace roomfix
