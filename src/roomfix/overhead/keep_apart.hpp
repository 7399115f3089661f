// The best of a sorted list that are not the same thing twice.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace roomfix {

/// Keeps the first `most` of `sorted` of which none is alike(kept, candidate) to one kept before it. Does not allocate.
template <class T, class Alike>
void keep_apart(std::vector<T>& sorted, std::size_t most, Alike alike) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < sorted.size() && kept < most; ++i) {
        const auto end = sorted.begin() + static_cast<std::ptrdiff_t>(kept);
        if (std::none_of(sorted.begin(), end, [&](const T& k) { return alike(k, sorted[i]); })) sorted[kept++] = sorted[i];
    }
    sorted.erase(sorted.begin() + static_cast<std::ptrdiff_t>(kept), sorted.end());
}

}  // namespace roomfix
