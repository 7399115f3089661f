#include "roomfix/pipeline/range_ears.hpp"

#include <algorithm>
#include <cmath>

namespace roomfix {
namespace {

constexpr double range_age = 0.3;      // s: ranges that old still belong together
constexpr double locate_again = 0.25;  // s between two places from ranges alone: they only start tracking

}  // namespace

Result<RangeEars> RangeEars::create(const Site& site) {
    RangeEars ears;
    for (std::size_t r = 0; r < site.robots.size(); ++r) {
        if (!site.robots[r].receiver) continue;
        Ear ear;
        ear.robot = static_cast<int>(r);
        auto locator = OnboardLocator::for_ranges(site, ear.robot);
        if (!locator) return locator.error();
        ear.locator = std::move(*locator);
        ears.ears_.push_back(std::move(ear));
    }
    return ears;
}

const RangeEars::Ear* RangeEars::find(int robot) const {
    const auto found = std::find_if(ears_.begin(), ears_.end(), [&](const Ear& ear) { return ear.robot == robot; });
    return found == ears_.end() ? nullptr : &*found;
}

void RangeEars::keep(const RangeObservation& range) {
    for (Ear& ear : ears_) {
        if (ear.robot != range.robot) continue;
        std::erase_if(ear.heard, [&](const RangeObservation& old) { return old.beacon == range.beacon; });
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

std::optional<PlaceSighting> RangeEars::places(int robot, Nanoseconds time) {
    for (Ear& ear : ears_) {
        if (ear.robot != robot || std::abs(to_seconds(time - ear.located)) < locate_again) continue;
        ear.located = time;
        OnboardResult result;
        ear.locator->locate(nullptr, near(robot, time), std::nullopt, -1, result);
        if (result.located.places.empty()) return std::nullopt;
        return PlaceSighting{robot, proposals_of(result.located.places)};
    }
    return std::nullopt;
}

}  // namespace roomfix
