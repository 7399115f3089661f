#include "roomfix/estimate/smoother.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace roomfix {
namespace {

constexpr double moving_speed = 0.15;  // m/s: faster, the direction of motion tells which end is the front

}  // namespace

Smoother::Smoother(std::vector<SiteRobot> robots, const SmootherSettings& settings)
    : robots_(std::move(robots)), settings_(settings), names_given_(robots_.size(), 0) {}

void Smoother::predict(Track& track, Nanoseconds time) const {
    const double dt = to_seconds(time - track.time);
    if (dt <= 0) return;
    track.state.head<2>() += dt * track.state.tail<2>();
    Eigen::Matrix4d transition = Eigen::Matrix4d::Identity();
    transition.topRightCorner<2, 2>() = dt * Eigen::Matrix2d::Identity();
    Eigen::Matrix<double, 4, 2> noise;
    noise << 0.5 * dt * dt * Eigen::Matrix2d::Identity(), dt * Eigen::Matrix2d::Identity();
    track.covariance = transition * track.covariance * transition.transpose() +
                       settings_.acceleration * settings_.acceleration * noise * noise.transpose();
    track.yaw_variance += settings_.turning * settings_.turning * dt * dt;
    track.time = time;
}

double Smoother::distance(const Track& track, const SilhouetteObservation& observation) const {
    const Eigen::Vector2d off = Eigen::Vector2d(observation.pose.x, observation.pose.y) - track.state.head<2>();
    // Cameras that see a robot from two sides disagree by a little more than their noise; 2 cm keeps them one robot.
    const Eigen::Matrix2d spread = track.covariance.topLeftCorner<2, 2>() + observation.covariance.topLeftCorner<2, 2>() +
                                   4e-4 * Eigen::Matrix2d::Identity();
    return off.dot(spread.inverse() * off);
}

void Smoother::update(Track& track, Nanoseconds time, const std::string& camera, const SilhouetteObservation& observation) const {
    const Eigen::Matrix2d noise = observation.covariance.topLeftCorner<2, 2>();
    const Eigen::Matrix<double, 4, 2> gain = track.covariance.leftCols<2>() * (track.covariance.topLeftCorner<2, 2>() + noise).inverse();
    track.state += gain * (Eigen::Vector2d(observation.pose.x, observation.pose.y) - track.state.head<2>());
    Eigen::Matrix4d keep = Eigen::Matrix4d::Identity();
    keep.leftCols<2>() -= gain;
    track.covariance = keep * track.covariance * keep.transpose() + gain * noise * gain.transpose();

    if (observation.yaw_known) {
        const double turn = 2 * std::numbers::pi / static_cast<double>(observation.hypotheses.size());
        const double speed = track.state.tail<2>().norm();
        if (!track.yaw_known) track.yaw = observation.pose.yaw;
        // Which of the poses that look alike: the one that goes on from the last, corrected once by the way it drives.
        double yaw = nearest_angle(observation.pose.yaw, track.yaw, turn);
        if (speed > moving_speed) {
            const double course = std::atan2(track.state.w(), track.state.z());
            if (std::abs(std::remainder(yaw - course, 2 * std::numbers::pi)) > 0.75 * turn) yaw = nearest_angle(observation.pose.yaw, course, turn);
        }
        if (std::abs(yaw - track.yaw) > 0.6 * turn) track.yaw_variance = observation.covariance(2, 2);
        const double k = track.yaw_known ? track.yaw_variance / (track.yaw_variance + observation.covariance(2, 2)) : 1;
        track.yaw = std::abs(yaw - track.yaw) > 0.6 * turn ? yaw : track.yaw + k * (yaw - track.yaw);
        track.yaw_variance = track.yaw_known ? (1 - k) * track.yaw_variance : observation.covariance(2, 2);
        track.yaw_known = true;
    } else if (track.state.tail<2>().norm() > 2 * moving_speed) {
        // A round robot looks where it drives.
        track.yaw = std::atan2(track.state.w(), track.state.z());
        const double speed2 = track.state.tail<2>().squaredNorm();
        track.yaw_variance = track.covariance.bottomRightCorner<2, 2>().trace() / (2 * speed2) + 0.01;
        track.yaw_known = true;
    }
    track.seen = time;
    ++track.sightings;
    std::erase_if(track.sources, [&](const auto& s) { return s.first == camera; });
    track.sources.emplace_back(camera, time);
}

void Smoother::start(Nanoseconds time, const std::string& camera, const SilhouetteObservation& observation) {
    Track track;
    track.robot = observation.robot;
    track.time = time;
    track.state.head<2>() = Eigen::Vector2d(observation.pose.x, observation.pose.y);
    track.covariance.topLeftCorner<2, 2>() = observation.covariance.topLeftCorner<2, 2>();
    track.covariance.bottomRightCorner<2, 2>() = Eigen::Matrix2d::Identity();  // up to about 1 m/s in any direction
    update(track, time, camera, observation);
    track.sightings = 1;
    tracks_.push_back(track);
}

void Smoother::add(Nanoseconds time, const std::string& camera, const std::vector<SilhouetteObservation>& observations) {
    for (Track& track : tracks_) {
        if (to_seconds(track.time - time) > settings_.coast) {
            ++late_;
            return;
        }
        predict(track, time);
    }
    std::erase_if(tracks_, [&](const Track& t) { return to_seconds(time - t.seen) > settings_.forget; });

    // Nearest pairs first; each track takes one observation of a frame, each observation goes to one track.
    struct Pair {
        double distance;
        std::size_t track, observation;
    };
    std::vector<Pair> pairs;
    for (std::size_t t = 0; t < tracks_.size(); ++t) {
        for (std::size_t o = 0; o < observations.size(); ++o) {
            if (tracks_[t].robot != observations[o].robot) continue;
            const double d = distance(tracks_[t], observations[o]);
            if (d < settings_.gate) pairs.push_back({d, t, o});
        }
    }
    std::sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) { return a.distance < b.distance; });
    std::vector<bool> track_used(tracks_.size(), false);
    std::vector<bool> used(observations.size(), false);
    for (const Pair& pair : pairs) {
        if (track_used[pair.track] || used[pair.observation]) continue;
        track_used[pair.track] = used[pair.observation] = true;
        update(tracks_[pair.track], time, camera, observations[pair.observation]);
    }
    for (std::size_t o = 0; o < observations.size(); ++o) {
        if (used[o]) continue;
        const auto robot = static_cast<std::size_t>(observations[o].robot);
        if (!robots_[robot].many) {
            // There is only one: it jumped, or the track was wrong. Follow what is seen now.
            std::erase_if(tracks_, [&](const Track& t) { return t.robot == observations[o].robot; });
            start(time, camera, observations[o]);
            tracks_.back().name = robots_[robot].id;
            continue;
        }
        start(time, camera, observations[o]);
    }
    for (Track& track : tracks_) {
        if (!track.name.empty() || track.sightings < settings_.confirmations) continue;
        const auto robot = static_cast<std::size_t>(track.robot);
        track.name = robots_[robot].id + "-" + std::to_string(++names_given_[robot]);
    }
}

std::vector<Fix> Smoother::fixes(Nanoseconds time) const {
    std::vector<Fix> fixes;
    for (Track track : tracks_) {
        if (track.name.empty()) continue;
        predict(track, std::max(time, track.time));
        const double unseen = to_seconds(time - track.seen);
        if (unseen > settings_.coast) continue;
        Fix fix;
        fix.time = time;
        fix.robot = track.name;
        fix.status = unseen > 0.35 ? FixStatus::coasting : FixStatus::ok;
        fix.pose = {track.state.x(), track.state.y(), wrap_angle(track.yaw)};
        fix.yaw_known = track.yaw_known;
        fix.covariance.setZero();
        fix.covariance.topLeftCorner<2, 2>() = track.covariance.topLeftCorner<2, 2>();
        fix.covariance(2, 2) = track.yaw_known ? track.yaw_variance : std::numbers::pi * std::numbers::pi / 3;
        for (const auto& [camera, seen] : track.sources) {
            if (to_seconds(time - seen) < 0.35) fix.sources.push_back(camera);
        }
        fixes.push_back(fix);
    }
    return fixes;
}

}  // namespace roomfix
