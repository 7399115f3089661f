// A list with room for a fixed number of elements and no memory of its own to manage.
#pragma once

#include <array>
#include <cassert>
#include <cstddef>

namespace roomfix {

template <class T, std::size_t N>
class FixedList {
public:
    static constexpr std::size_t capacity() { return N; }
    std::size_t size() const { return size_; }
    bool empty() const { return size_ == 0; }
    void clear() { size_ = 0; }
    /// There must be room.
    void push_back(const T& value) {
        assert(size_ < N);
        items_[size_++] = value;
    }
    T& operator[](std::size_t i) { return items_[i]; }
    const T& operator[](std::size_t i) const { return items_[i]; }
    auto begin() { return items_.begin(); }
    auto end() { return items_.begin() + static_cast<std::ptrdiff_t>(size_); }
    auto begin() const { return items_.begin(); }
    auto end() const { return items_.begin() + static_cast<std::ptrdiff_t>(size_); }

private:
    std::array<T, N> items_;
    std::size_t size_ = 0;
};

}  // namespace roomfix
