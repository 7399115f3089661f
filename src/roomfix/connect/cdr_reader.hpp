// CDR as others send it: either byte order, each number at a multiple of its own size, counted from behind the four bytes at the beginning.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <type_traits>

namespace roomfix {

/// Reads what stands there and nothing behind it: from the first value on that is not whole, all are zero or empty and `good` is false.
class CdrReader {
public:
    /// A message with its four bytes; they must say plain CDR (not a later version of it, nor a list of parameters). It must outlive the reader.
    explicit CdrReader(std::span<const std::uint8_t> message)
        : swapped_(message.size() > 1 && (message[1] == 1) != (std::endian::native == std::endian::little)),
          good_(message.size() >= header && message[0] == 0 && message[1] <= 1),
          body_(good_ ? message.subspan(header) : std::span<const std::uint8_t>()) {}

    bool good() const { return good_; }
    std::size_t left() const { return body_.size() - at_; }

    template <class T>
    requires std::is_arithmetic_v<T> T get() {
        align(sizeof(T));
        std::uint8_t bytes[sizeof(T)] = {};
        const auto found = take(sizeof(T));
        std::copy(found.begin(), found.end(), bytes);
        if (swapped_) std::reverse(bytes, bytes + sizeof(T));
        T value;
        std::memcpy(&value, bytes, sizeof(T));
        return value;
    }

    void get(std::span<double> values) {
        for (double& value : values) value = get<double>();
    }

    /// Without the zero at its end.
    std::string text() {
        const auto characters = take(get<std::uint32_t>());
        const std::string text(characters.begin(), characters.end());
        return text.substr(0, text.find('\0'));
    }

    /// So many bytes as they stand; none where there are fewer.
    std::span<const std::uint8_t> take(std::size_t count) {
        if (!good_ || count > left()) {
            good_ = false;
            return {};
        }
        at_ += count;
        return body_.subspan(at_ - count, count);
    }

private:
    static constexpr std::size_t header = 4;

    void align(std::size_t size) { take((size - at_ % size) % size); }

    bool swapped_, good_;
    std::span<const std::uint8_t> body_;
    std::size_t at_ = 0;
};

}  // namespace roomfix
