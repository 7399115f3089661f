// Reads coded pictures of a network camera as they come.
#pragma once

#include <atomic>
#include <memory>
#include <string>

#include "roomfix/base/result.hpp"
#include "roomfix/connect/libav_stream.hpp"

namespace roomfix {

class PacketReader {
public:
    virtual ~PacketReader() = default;
    /// Waits for the next picture.
    virtual Result<StreamPacket> read() = 0;
    /// What makes pictures of the packets; null where they are JPEGs.
    virtual Result<std::unique_ptr<PictureDecoder>> decoder() const = 0;
};

/// Connects to an address. HTTP answers of many parts are taken apart by us, which keeps their JPEGs and time stamps as they came; libav reads everything else.
Result<std::unique_ptr<PacketReader>> open_packet_reader(const std::string& address, const Patience& patience);

}  // namespace roomfix
