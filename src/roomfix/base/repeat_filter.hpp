// Messages that come again and again are told a few times, and then only counted.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace roomfix {

class RepeatFilter {
public:
    /// The same message is told `most` times within `interval` (s).
    explicit RepeatFilter(int most = 5, double interval = 60) : most_(most), interval_(interval) {}

    /// The message as it is to be told at `now` (s): with how often it was held back before; nothing where it is held back.
    std::optional<std::string> pass(const std::string& text, double now);
    /// At the end: what was held back and is not told yet, each with how often.
    std::vector<std::string> rest();

private:
    struct Heard {
        double since = 0;  // s, of the first one of this interval
        int told = 0;      // within it
        long held = 0;     // since it was last told
    };
    int most_;
    double interval_;
    std::map<std::string, Heard> heard_;
};

}  // namespace roomfix
