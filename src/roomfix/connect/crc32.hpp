// The checksum of zip, PNG and MCAP (CRC-32, polynomial 0xEDB88320 with its bits reversed).
#pragma once

#include <cstdint>
#include <span>

namespace roomfix {

class Crc32 {
public:
    void add(std::span<const std::uint8_t> bytes);
    std::uint32_t value() const { return ~remainder_; }

private:
    std::uint32_t remainder_ = 0xffffffff;
};

std::uint32_t crc32(std::span<const std::uint8_t> bytes);

}  // namespace roomfix
