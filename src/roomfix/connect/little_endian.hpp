// Numbers as bytes, the lowest first, on every machine.
#pragma once

#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <type_traits>
#include <vector>

namespace roomfix {

using Bytes = std::vector<std::uint8_t>;

template <std::integral T>
void append(Bytes& bytes, T value) {
    const auto bits = static_cast<std::make_unsigned_t<T>>(value);
    for (std::size_t i = 0; i < sizeof(T); ++i) bytes.push_back(static_cast<std::uint8_t>(bits >> (8 * i)));
}

inline void append(Bytes& bytes, double value) { append(bytes, std::bit_cast<std::uint64_t>(value)); }

/// The characters alone.
inline void append_text(Bytes& bytes, std::string_view text) { bytes.insert(bytes.end(), text.begin(), text.end()); }

}  // namespace roomfix
