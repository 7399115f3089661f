// Network streams and their pictures through libav, without its headers.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "roomfix/base/result.hpp"
#include "roomfix/base/time.hpp"
#include "roomfix/imaging/yuv_picture.hpp"

namespace roomfix {

/// Waiting ends with an error after some seconds, or soon after one of the flags was set.
struct Patience {
    const std::atomic<bool>& stop;
    const std::atomic<bool>& closed;
    double to_open = 5;  // s
    double to_read = 3;
};

/// One coded picture of a stream.
struct StreamPacket {
    std::vector<std::uint8_t> bytes;
    double steady = 0;                // s of a clock that only goes forward: when its first bytes came
    Nanoseconds system = 0;           // of our clock, at the same moment
    std::optional<double> media;      // s of the sender's media clock, as its time stamps state
    std::optional<Nanoseconds> wall;  // of the sender's wall clock, by its sender reports (RTCP)
    bool key = false;                 // may be decoded without those before
};

class PictureDecoder;

/// The video stream behind an address.
class PacketStream {
public:
    static Result<std::unique_ptr<PacketStream>> open(const std::string& address, const Patience& patience);
    ~PacketStream();
    /// Waits for the next picture. Of RTSP, where pictures come in pieces, that is when the next one begins.
    Result<StreamPacket> read();
    /// Pictures are whole JPEGs each.
    bool is_jpeg() const;
    Result<std::unique_ptr<PictureDecoder>> decoder() const;

private:
    struct Impl;
    explicit PacketStream(std::unique_ptr<Impl> impl);
    Result<StreamPacket> read_piece();

    std::unique_ptr<Impl> impl_;
};

/// Makes pictures of a stream's packets, in the order of the packets.
class PictureDecoder {
public:
    struct Impl;
    explicit PictureDecoder(std::unique_ptr<Impl> impl);
    ~PictureDecoder();
    /// Decodes a packet; `number` comes back with its picture. An error if it is damaged: the next one may do.
    Result<void> feed(const StreamPacket& packet, std::int64_t number);
    /// The number of the next picture that is ready, if there is one; `picture` is it then.
    std::optional<std::int64_t> take();
    /// The picture that was taken last, until the next `take`. An error if its pixels are of a kind that is not read.
    Result<YuvView> picture() const;

private:
    std::unique_ptr<Impl> impl_;
};

/// Bytes of an HTTP answer.
class ByteStream {
public:
    static Result<std::unique_ptr<ByteStream>> open(const std::string& address, const Patience& patience);
    ~ByteStream();
    const std::string& content_type() const;
    /// Waits for the next bytes; valid until the next call.
    Result<std::span<const std::uint8_t>> read();

private:
    struct Impl;
    explicit ByteStream(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

}  // namespace roomfix
