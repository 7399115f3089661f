// Learns what a robot looks like from pictures in which it stands at different places: its body and its poses in turns.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "roomfix/base/result.hpp"
#include "roomfix/calibrate/surface_spots.hpp"
#include "roomfix/overhead/body_search.hpp"

namespace roomfix {

struct BodyLearnerSettings {
    BodySearchSettings search;
    OccupancySettings occupancy;
    SpotSettings spots;
    int rounds = 5;                // of body and poses in turns
    std::size_t least_sights = 3;  // a thing seen less often is nobody's robot
    double least_way = 0.5;        // of the body's radius: how far apart its places must be, or it never moved
    double most_misfit = 0.60;     // part by which its size may differ from what the site file says, beyond 3 size_sigma
    std::size_t seeds = 120;       // single sights whose look is tried on all others
    std::size_t tries = 8;         // different guesses at what the robot is that are learned from in full
    double enough = 30;            // nats by which a look found again in a moment is found for sure: more say no more
    int candidates = 40;           // places of each moment that are looked at
};

struct BodyLesson {
    LearnedBody body;
    std::vector<BodySight> sights;      // that it was learned from, with the robot's poses
    std::vector<std::size_t> left_out;  // moments that show no such robot
    double per_spot = 0;                // nats by which the look explains a spot better than anything else does, mean over the sights
};

/// `moments`: of fixed cameras, their evidence with its colours. `rough`: the robot as the site file describes it. An error says why these
/// pictures teach nothing.
Result<BodyLesson> learn_body(const std::vector<BodyMoment>& moments, const SiteRobot& rough, const BodyLearnerSettings& settings = {},
                              const std::function<void(double)>& progress = {});

}  // namespace roomfix
