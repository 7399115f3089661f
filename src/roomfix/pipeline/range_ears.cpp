#include "roomfix/pipeline/range_ears.hpp"

#include <algorithm>
#include <cmath>

namespace roomfix {
namespace {

constexpr double range_age = 0.3;  // s: ranges that old still belong together

}  // namespace

RangeEars::RangeEars(const Site& site) {
    for (std::size_t r = 0; r < site.robots.size(); ++r) {
        if (!site.robots[r].receivers.empty()) ears_.push_back({static_cast<int>(r), {}});
    }
}

const RangeEars::Ear* RangeEars::find(int robot) const {
    const auto found = std::find_if(ears_.begin(), ears_.end(), [&](const Ear& ear) { return ear.robot == robot; });
    return found == ears_.end() ? nullptr : &*found;
}

void RangeEars::keep(const RangeObservation& range) {
    for (Ear& ear : ears_) {
        if (ear.robot != range.robot) continue;
        std::erase_if(ear.heard, [&](const RangeObservation& old) { return old.beacon == range.beacon && old.receiver == range.receiver; });
        ear.heard.push_back(range);
    }
}

std::vector<RangeObservation> RangeEars::near(int robot, Nanoseconds time) const {
    std::vector<RangeObservation> near;
    if (const Ear* ear = find(robot)) {
        for (const RangeObservation& range : ear->heard) {
            if (std::abs(to_seconds(time - range.time)) < range_age) near.push_back(range);
        }
    }
    return near;
}

}  // namespace roomfix
