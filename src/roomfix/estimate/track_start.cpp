#include "roomfix/estimate/track_start.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "roomfix/estimate/time_error_model.hpp"

namespace roomfix {
namespace {

constexpr double vague_yaw = 0.5;  // rad, 1 sigma: a direction seen no better is as good as none to start from
constexpr int yaw_starts = 12;     // of a robot with odometry whose front nobody knows

/// What was learned about odometry and sensors goes along to a new place.
void keep_learned(Belief& fresh, const Belief& old) {
    const int learned = old.size - state_scale;
    fresh.size = old.size;
    fresh.slow = old.slow;
    fresh.mean.segment(state_scale, learned) = old.mean.segment(state_scale, learned);
    for (int i = state_scale; i < old.size; ++i) {
        fresh.covariance.row(i).head(old.size).setZero();
        fresh.covariance.col(i).head(old.size).setZero();
    }
    fresh.covariance.block(state_scale, state_scale, learned, learned) = old.covariance.block(state_scale, state_scale, learned, learned);
}

}  // namespace

Belief start_belief(const PlaceProposal& place, int robot, const TrackingModels& models) {
    Eigen::Matrix3d covariance = place.covariance;
    if (!place.yaw_known) {
        covariance.row(2).setZero();
        covariance.col(2).setZero();
        covariance(2, 2) = unknown_yaw_variance;
    }
    const TrackerSettings& settings = models.settings;
    Belief belief = belief_at(place.pose, covariance, settings.start_speed, settings.start_turning, models.odometry[static_cast<std::size_t>(robot)]);
    for (int i = 0; i < 3; ++i) {  // it was there then, and moves as nobody knows yet
        const double variance = belief.covariance(state_vx + i, state_vx + i);
        belief.covariance(i, i) += (place.late * place.late + place.time_sigma * place.time_sigma) * variance;
        belief.covariance(i, state_vx + i) = belief.covariance(state_vx + i, i) = -place.late * variance;
    }
    return belief;
}

void add_places(Track& track, const std::vector<PlaceProposal>& places, double share, const TrackingModels& models) {
    const bool drives = !models.driven[static_cast<std::size_t>(track.robot)].empty();
    double sum = 0;
    for (const PlaceProposal& place : places) sum += place.weight;
    const bool fresh = track.belief.hypotheses.empty();
    const Belief* old = fresh ? nullptr : &track.belief.hypotheses.front().belief;
    std::vector<Hypothesis> added;
    for (const PlaceProposal& place : places) {
        const int turns = !place.yaw_known && drives ? yaw_starts : 1;
        for (int i = 0; i < turns; ++i) {
            Belief belief = start_belief(place, track.robot, models);
            if (turns > 1) {
                const double step = 2 * std::numbers::pi / turns;
                belief.mean[state_yaw] = i * step;
                belief.covariance(state_yaw, state_yaw) = 0.25 * step * step;
            }
            if (old) keep_learned(belief, *old);
            added.push_back({belief, std::log(place.weight / sum / turns), track.time});
        }
    }
    for (Hypothesis& h : added) {
        const bool known = std::any_of(track.belief.hypotheses.begin(), track.belief.hypotheses.end(),
                                       [&](const Hypothesis& other) { return pose_distance(other.belief, h.belief) < 9; });
        if (!fresh && known) continue;
        h.log_weight += std::log(share);
        if (track.belief.hypotheses.size() < most_hypotheses) track.belief.hypotheses.push_back(h);
    }
    settle(track.belief);
}

void start(Track& track, const std::vector<PlaceProposal>& places, Nanoseconds time, const TrackingModels& models) {
    track.belief.hypotheses.clear();
    track.time = track.born = track.seen = time;
    track.absence = 0;
    track.sightings = 1;
    track.budget = most_budget;
    track.cloud = {};
    track.doubt.setZero();
    add_places(track, places, 1, models);
}

void list_places(const PoseObservation& observation, const PoseSource& source, std::vector<PlaceProposal>& places) {
    places.clear();
    const bool yaw_known = observation.yaw_known && observation.covariance(2, 2) < vague_yaw * vague_yaw;
    const int turns = yaw_known ? std::max(observation.like_turns, 1) : 1;
    for (int i = 0; i < turns; ++i) {
        const double yaw = wrap_angle(observation.pose.yaw + 2 * std::numbers::pi * i / turns);
        places.push_back({{observation.pose.x, observation.pose.y, yaw},
                          observation.covariance,
                          yaw_known,
                          1,
                          observation.late,
                          time_sigma(source.time_offset_sigma, observation.time_error)});
    }
}

std::vector<PlaceProposal> places_of(const PoseObservation& observation, const PoseSource& source) {
    std::vector<PlaceProposal> places;
    list_places(observation, source, places);
    return places;
}

}  // namespace roomfix
