#include "roomfix/evaluate/moments.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

namespace roomfix {
namespace {

/// A name's newest fix and how far from it each target was at its time.
struct NewestFix {
    const Fix* fix = nullptr;
    std::vector<std::optional<double>> distances;  // m; nothing where the target's place at that time is not known
};

double distance_between(const Pose2& a, const Pose2& b) { return std::hypot(a.x - b.x, a.y - b.y); }

}  // namespace

std::vector<Nanoseconds> times_of(const Truth& truth) {
    std::vector<Nanoseconds> times;
    for (const auto& [name, poses] : truth) {
        for (const StampedPose& pose : poses) times.push_back(pose.time);
    }
    std::sort(times.begin(), times.end());
    times.erase(std::unique(times.begin(), times.end()), times.end());
    return times;
}

Moments moments_of(const std::vector<Fix>& fixes, const Truth& truth, const std::vector<Nanoseconds>& times, double cutoff, double fresh) {
    Moments moments;
    moments.cutoff = cutoff;
    std::map<std::string, std::size_t> number_of;
    for (const Fix& fix : fixes) {
        if (!fix.robot.empty() && fix.status != FixStatus::none) number_of.try_emplace(fix.robot, 0);
    }
    for (auto& [name, number] : number_of) {
        number = moments.tracks.size();
        moments.tracks.push_back(name);
    }
    for (const auto& [name, poses] : truth) moments.targets.push_back(name);

    std::vector<NewestFix> newest(moments.tracks.size());
    std::size_t next = 0;
    for (const Nanoseconds time : times) {
        for (; next < fixes.size() && fixes[next].time <= time; ++next) {
            const auto number = number_of.find(fixes[next].robot);
            if (number != number_of.end()) newest[number->second] = {&fixes[next], {}};
        }
        Moment moment;
        moment.time = time;
        std::vector<std::optional<TruePose>> places;
        for (const auto& [name, poses] : truth) {
            places.push_back(pose_at(poses, time));
            if (places.back()) moment.targets.push_back(static_cast<int>(places.size()) - 1);
        }
        for (std::size_t track = 0; track < newest.size(); ++track) {
            auto& [fix, distances] = newest[track];
            if (fix == nullptr || fix->status == FixStatus::none || to_seconds(time - fix->time) > fresh) continue;
            moment.tracks.push_back(static_cast<int>(track));
            if (distances.empty()) {
                for (const auto& [name, poses] : truth) {
                    const auto then = pose_at(poses, fix->time);
                    distances.push_back(then ? std::optional(distance_between(*then, fix->pose)) : std::nullopt);
                }
            }
            for (const int target : moment.targets) {
                const auto t = static_cast<std::size_t>(target);
                const double distance = distances[t] ? *distances[t] : distance_between(*places[t], fix->pose);
                if (distance <= cutoff) moment.pairs.push_back({target, static_cast<int>(track), distance});
            }
        }
        moments.all.push_back(std::move(moment));
    }
    return moments;
}

}  // namespace roomfix
