// Text line by line.
#pragma once

#include <string_view>

namespace roomfix {

/// Calls `take(line, number)` for each line that is not blank, without its end; the first line has the number 1.
template <class Take>
void each_line(std::string_view text, const Take& take) {
    for (long number = 1; !text.empty(); ++number) {
        const std::size_t end = text.find('\n');
        std::string_view line = text.substr(0, end);
        text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
        if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
        if (line.find_first_not_of(" \t") != std::string_view::npos) take(line, number);
    }
}

}  // namespace roomfix
