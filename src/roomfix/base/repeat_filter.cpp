#include "roomfix/base/repeat_filter.hpp"

#include <fmt/format.h>

namespace roomfix {
namespace {

constexpr std::size_t most_kept = 1000;  // messages

std::string with_count(const std::string& text, long held) { return held > 0 ? fmt::format("{} (and {} times more before)", text, held) : text; }

}  // namespace

std::optional<std::string> RepeatFilter::pass(const std::string& text, double now) {
    // Messages of long ago that were all told are forgotten.
    if (heard_.size() >= most_kept) std::erase_if(heard_, [&](const auto& h) { return h.second.held == 0 && now - h.second.since >= interval_; });
    if (heard_.size() >= most_kept && !heard_.contains(text)) return text;
    const auto [place, first] = heard_.try_emplace(text);
    Heard& heard = place->second;
    if (first || now - heard.since >= interval_) heard = {now, 0, heard.held};
    if (heard.told >= most_) {
        ++heard.held;
        return std::nullopt;
    }
    ++heard.told;
    const std::string told = with_count(text, heard.held);
    heard.held = 0;
    return told;
}

std::vector<std::string> RepeatFilter::rest() {
    std::vector<std::string> texts;
    for (auto& [text, heard] : heard_) {
        if (heard.held > 0) texts.push_back(fmt::format("{} ({} times more)", text, heard.held));
        heard.held = 0;
    }
    return texts;
}

}  // namespace roomfix
