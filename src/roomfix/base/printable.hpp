// Text from outside, as it can be shown.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace roomfix {

/// The text with '?' for each byte that no terminal or page can show: control characters and what is not UTF-8.
std::string printable(std::string_view text);

/// Where the first byte is that is not UTF-8.
std::optional<std::size_t> first_that_is_not_utf8(std::string_view text);

}  // namespace roomfix
