// Texts as YAML.
#pragma once

#include <string>

namespace roomfix {

/// A text that YAML reads as it is, whatever is in it.
inline std::string quoted_text(const std::string& text) {
    std::string result = "'";
    for (const char c : text) result += c == '\'' ? "\'\'" : std::string(1, c);
    return result + "'";
}

}  // namespace roomfix
