// The middle of some values.
#pragma once

#include <algorithm>
#include <cstddef>
#include <type_traits>

namespace roomfix {

/// The upper one of two middle values; 0 where there are no values. Brings them into another order.
template <class Values>
auto median(Values& values) {
    using Value = std::decay_t<decltype(*values.begin())>;
    if (values.empty()) return Value{};
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return Value{*middle};
}

}  // namespace roomfix
