// Text from outside, as it can be shown.
#pragma once

#include <string>
#include <string_view>

namespace roomfix {

/// The text with '?' for each byte that no terminal or page can show: control characters and what is not UTF-8.
std::string printable(std::string_view text);

}  // namespace roomfix
