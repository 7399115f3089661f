#include "roomfix/pipeline/sigma_advice.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace roomfix {
namespace {

constexpr double too_small = 1.5;  // times: less is no news

std::string name_of(const Receiver& receiver) { return receiver.id.empty() ? "receiver" : "receivers." + receiver.id; }

/// Two digits: nobody knows a sigma better.
double rounded_up(double value) {
    if (!(value > 0)) return 0;
    const double unit = std::pow(10, std::floor(std::log10(value)) - 1);
    return std::ceil(value / unit - 1e-9) * unit;
}

/// What all ranges, and those to each beacon, have in common, as `bias_sigma` states both.
double bias_of(const RangeErrors& errors) { return std::max(errors.common, errors.own / own_part); }
/// What is another from one range to the next, or from one place to the next.
double scatter_of(const RangeErrors& errors, double stated) { return std::hypot(errors.factor * stated, errors.wander, errors.sway); }

/// Where a number of the robot stands; null: it has no such sense or key.
double* number_of(SiteRobot& robot, const std::string& sense, const std::string& key) {
    if (sense == "odometry" && robot.odometry) {
        if (key == "scale_sigma") return &robot.odometry->scale_sigma;
        if (key == "turn_scale_sigma") return &robot.odometry->turn_scale_sigma;
        if (key == "drift_sigma") return &robot.odometry->drift_sigma;
    }
    if (sense == "detector" && robot.detector) {
        if (key == "range_sigma") return &robot.detector->range_sigma;
        if (key == "bearing_sigma") return &robot.detector->bearing_sigma;
    }
    for (Receiver& receiver : robot.receivers) {
        if (name_of(receiver) != sense) continue;
        if (key == "sigma") return &receiver.sigma;
        if (key == "bias_sigma") return &receiver.bias_sigma;
        if (key == "scale_sigma") return &receiver.scale_sigma;
    }
    return nullptr;
}

}  // namespace

std::vector<SigmaAdvice> sigma_advice(const Tracker& tracker) {
    std::vector<SigmaAdvice> all;
    const Site& site = tracker.models().site;
    for (std::size_t r = 0; r < site.robots.size(); ++r) {
        SiteRobot robot = site.robots[r];
        const Track* track = tracker.track(static_cast<int>(r));
        if (track == nullptr || track->searched == never) continue;
        const auto advise = [&](const std::string& sense, const char* key, double found, double least) {
            const double* stated = number_of(robot, sense, key);
            if (stated != nullptr && found > std::max(too_small * *stated, least)) all.push_back({robot.id, sense, key, *stated, rounded_up(found)});
        };
        const Belief& belief = track->belief.best();
        if (robot.odometry) {
            advise("odometry", "scale_sigma", std::abs(belief.mean[state_scale]), 0.01);
            advise("odometry", "turn_scale_sigma", std::abs(belief.mean[state_turn_scale]), 0.01);
            advise("odometry", "drift_sigma", std::abs(belief.mean[state_drift]), 0.001);
        }
        const SenseNoise& noise = track->noise;
        for (const Receiver& receiver : robot.receivers) {
            advise(name_of(receiver), "sigma", scatter_of(noise.receiver, receiver.sigma), 0.001);
            advise(name_of(receiver), "bias_sigma", bias_of(noise.receiver), receiver.sigma);
            advise(name_of(receiver), "scale_sigma", noise.receiver.stretch.scale, 0.002);
        }
        if (!robot.detector) continue;
        advise("detector", "range_sigma", std::hypot(scatter_of(noise.detector, robot.detector->range_sigma), noise.detector.common), 0.001);
        advise("detector", "bearing_sigma", std::hypot(noise.bearing * robot.detector->bearing_sigma, noise.bearing_sway, noise.bearing_common), 1e-4);
    }
    return all;
}

std::string text_of(const SigmaAdvice& advice) {
    return fmt::format("robots.{}.{}.{}: {:.3g} is stated, or taken where nothing is; this recording shows {:.3g}", advice.robot, advice.sense, advice.key,
                       advice.stated, advice.found);
}

SiteRobot advised(SiteRobot robot, const std::vector<SigmaAdvice>& advice) {
    for (const SigmaAdvice& one : advice) {
        if (one.robot != robot.id) continue;
        if (one.sense == "odometry" && !robot.odometry) robot.odometry.emplace();
        if (one.sense == "detector" && !robot.detector) robot.detector.emplace();
        if (one.sense == "receiver" && robot.receivers.empty()) robot.receivers.push_back(somewhere_on(robot));
        if (double* number = number_of(robot, one.sense, one.key)) *number = one.found;
    }
    return robot;
}

}  // namespace roomfix
