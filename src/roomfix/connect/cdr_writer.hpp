// CDR, as DDS and ROS 2 send messages: little endian, each number at a multiple of its own size, counted from behind the four bytes at the beginning.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <utility>

#include "roomfix/connect/little_endian.hpp"

namespace roomfix {

class CdrWriter {
public:
    void put(std::uint8_t value) { bytes_.push_back(value); }
    void put(bool value) { bytes_.push_back(value ? 1 : 0); }
    void put(std::int32_t value) { put_aligned(value); }
    void put(std::uint32_t value) { put_aligned(value); }
    void put(double value) { put_aligned(value); }
    /// Its length with the zero at its end, its characters, the zero.
    void put(std::string_view text);
    void put(const char*) = delete;  // it would become a bool
    /// Arrays of a fixed length have no count before them.
    void put_array(std::span<const double> values);
    /// The number of elements that follow, of a sequence.
    void put_count(std::size_t count) { put(static_cast<std::uint32_t>(count)); }
    void put_bytes(std::span<const std::uint8_t> values);

    Bytes take() { return std::move(bytes_); }

private:
    static constexpr std::size_t header = 4;

    template <class T>
    void put_aligned(T value) {
        while ((bytes_.size() - header) % sizeof(T) != 0) bytes_.push_back(0);
        append(bytes_, value);
    }

    Bytes bytes_ = {0, 1, 0, 0};  // plain CDR, little endian, no options
};

}  // namespace roomfix
