#include "roomfix/evaluate/unknown_things.hpp"

#include <algorithm>
#include <cmath>

#include "roomfix/evaluate/gospa.hpp"

namespace roomfix {

UnknownThings judge_things(const std::vector<Fix>& fixes, const Truth& things, const std::vector<Nanoseconds>& times, double cutoff, double fresh) {
    UnknownThings judged;
    judged.in_truth = !things.empty();
    judged.fixes = static_cast<std::size_t>(std::count_if(fixes.begin(), fixes.end(), [](const Fix& fix) { return fix.status != FixStatus::none; }));
    if (things.empty()) return judged;
    const Moments moments = moments_of(fixes, things, times, cutoff, fresh);
    if (!times.empty()) judged.minutes = to_seconds(times.back() - times.front()) / 60;
    std::vector<double> errors;
    std::vector<bool> was_false(moments.tracks.size(), false);
    for (const Moment& moment : moments.all) {
        std::vector<bool> is_false(moments.tracks.size(), false);
        for (const int track : moment.tracks) is_false[static_cast<std::size_t>(track)] = true;
        for (const CloseBy& pair : gospa_pairs(moments, moment)) {
            is_false[static_cast<std::size_t>(pair.track)] = false;
            errors.push_back(pair.distance);
        }
        judged.listed += moment.targets.size();
        for (std::size_t track = 0; track < is_false.size(); ++track) judged.false_ones += is_false[track] && !was_false[track];
        was_false = std::move(is_false);
    }
    judged.found = errors.size();
    judged.error = summarise(std::move(errors));
    return judged;
}

void count_on_thing(const Fix& fix, bool away, const Truth& things, double near, UnknownThings& count) {
    if (fix.status != FixStatus::ok || fix.robot.empty()) return;
    ++count.robot_fixes;
    count.robots_on_one += away && std::any_of(things.begin(), things.end(), [&](const auto& thing) {
                               const auto there = pose_at(thing.second, fix.time);
                               return there && std::hypot(there->x - fix.pose.x, there->y - fix.pose.y) < near;
                           });
}

}  // namespace roomfix
