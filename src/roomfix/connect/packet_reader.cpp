#include "roomfix/connect/packet_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "roomfix/base/steady_now.hpp"
#include "roomfix/connect/multipart_reader.hpp"
#include "roomfix/connect/shown_address.hpp"

namespace roomfix {
namespace {

class LibavReader final : public PacketReader {
public:
    explicit LibavReader(std::unique_ptr<PacketStream> stream) : stream_(std::move(stream)) {}
    Result<StreamPacket> read() override { return stream_->read(); }
    Result<std::unique_ptr<PictureDecoder>> decoder() const override {
        if (stream_->is_jpeg()) return std::unique_ptr<PictureDecoder>();
        return stream_->decoder();
    }

private:
    std::unique_ptr<PacketStream> stream_;
};

class MultipartCamera final : public PacketReader {
public:
    explicit MultipartCamera(std::unique_ptr<ByteStream> stream) : stream_(std::move(stream)) {}
    Result<StreamPacket> read() override {
        std::optional<MultipartPart> part = parts_.take();
        while (!part) {
            const auto bytes = stream_->read();
            if (!bytes) return bytes.error();
            if (auto fed = parts_.feed(*bytes, steady_now()); !fed) return fed.error();
            part = parts_.take();
        }
        StreamPacket packet;
        packet.steady = part->began;
        packet.system = system_now() - from_seconds(steady_now() - part->began);
        packet.bytes = std::move(part->body);
        packet.key = true;
        if (part->timestamp) set_times(*part->timestamp, packet);
        return packet;
    }
    Result<std::unique_ptr<PictureDecoder>> decoder() const override { return std::unique_ptr<PictureDecoder>(); }

private:
    /// Programs write the time since 1970 or since the machine was started.
    static void set_times(double timestamp, StreamPacket& packet) {
        constexpr double this_century = 1e9, next_century = 4e9;
        if (timestamp < 0 || timestamp > next_century) return;
        packet.media = timestamp;
        if (timestamp > this_century) packet.wall = from_seconds(timestamp);
    }

    std::unique_ptr<ByteStream> stream_;
    MultipartReader parts_;
};

bool starts_with_word(std::string text, const std::string& word) {
    std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return text.starts_with(word);
}

}  // namespace

Result<std::unique_ptr<PacketReader>> open_packet_reader(const std::string& address, const Patience& patience) {
    if (address.starts_with("http://") || address.starts_with("https://")) {
        auto bytes = ByteStream::open(address, patience);
        if (!bytes) return bytes.error();
        const std::string& type = (*bytes)->content_type();
        if (starts_with_word(type, "multipart/")) return std::unique_ptr<PacketReader>(std::make_unique<MultipartCamera>(std::move(*bytes)));
        if (starts_with_word(type, "text/") || starts_with_word(type, "image/")) {
            return Error{fmt::format("{}: there is no stream but one {}: look up the path of the camera's MJPEG stream in its manual", shown_address(address),
                                     starts_with_word(type, "text/") ? "page" : "picture")};
        }
    }
    auto stream = PacketStream::open(address, patience);
    if (!stream) return stream.error();
    return std::unique_ptr<PacketReader>(std::make_unique<LibavReader>(std::move(*stream)));
}

}  // namespace roomfix
