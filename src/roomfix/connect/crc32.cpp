#include "roomfix/connect/crc32.hpp"

#include <array>

namespace roomfix {
namespace {

constexpr std::size_t at_once = 8;  // bytes
using Table = std::array<std::uint32_t, 256>;

/// Of each byte that stands so many bytes before the end of eight: what it leaves.
constexpr std::array<Table, at_once> make_tables() {
    std::array<Table, at_once> tables = {};
    for (std::uint32_t byte = 0; byte < 256; ++byte) {
        std::uint32_t rest = byte;
        for (int bit = 0; bit < 8; ++bit) rest = (rest >> 1) ^ (rest & 1 ? 0xEDB88320U : 0U);
        tables[0][byte] = rest;
    }
    for (std::size_t n = 1; n < at_once; ++n) {
        for (std::size_t byte = 0; byte < 256; ++byte) {
            const std::uint32_t before = tables[n - 1][byte];
            tables[n][byte] = (before >> 8) ^ tables[0][before & 0xff];
        }
    }
    return tables;
}

constexpr std::array<Table, at_once> tables = make_tables();

}  // namespace

void Crc32::add(std::span<const std::uint8_t> bytes) {
    std::uint32_t rest = remainder_;
    for (; bytes.size() >= at_once; bytes = bytes.subspan(at_once)) {
        std::uint32_t next = 0;
        for (std::size_t i = 0; i < at_once; ++i) {
            const std::uint32_t mixed = i < 4 ? bytes[i] ^ (rest >> (8 * i)) : bytes[i];
            next ^= tables[at_once - 1 - i][mixed & 0xff];
        }
        rest = next;
    }
    for (const std::uint8_t byte : bytes) rest = (rest >> 8) ^ tables[0][(rest ^ byte) & 0xff];
    remainder_ = rest;
}

std::uint32_t crc32(std::span<const std::uint8_t> bytes) {
    Crc32 sum;
    sum.add(bytes);
    return sum.value();
}

}  // namespace roomfix
