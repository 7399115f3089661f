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
    track.covariance = transition * track.covariance * transition.transpose() + settings_.acceleration * settings_.acceleration * noise * noise.transpose();
    track.yaw_variance += settings_.turning * settings_.turning * dt * dt;
    track.time = time;
}

double Smoother::distance(const Track& track, const PoseObservation& observation) const {
    const Eigen::Vector2d off = Eigen::Vector2d(observation.pose.x, observation.pose.y) - track.state.head<2>();
    // Two robots cannot stand closer than their size; a quarter of it keeps disagreeing cameras and people's swinging arms
    // one target.
    const double slack = 0.25 * half_size(robots_[static_cast<std::size_t>(track.robot)].shape).x();
    const Eigen::Matrix2d spread =
        track.covariance.topLeftCorner<2, 2>() + observation.covariance.topLeftCorner<2, 2>() + slack * slack * Eigen::Matrix2d::Identity();
    return off.dot(spread.inverse() * off);
}

void Smoother::update(Track& track, Nanoseconds time, const std::string& camera, const PoseObservation& observation) const {
    const Eigen::Matrix2d noise = observation.covariance.topLeftCorner<2, 2>();
    const Eigen::Matrix<double, 4, 2> gain = track.covariance.leftCols<2>() * (track.covariance.topLeftCorner<2, 2>() + noise).inverse();
    track.state += gain * (Eigen::Vector2d(observation.pose.x, observation.pose.y) - track.state.head<2>());
    Eigen::Matrix4d keep = Eigen::Matrix4d::Identity();
    keep.leftCols<2>() -= gain;
    track.covariance = keep * track.covariance * keep.transpose() + gain * noise * gain.transpose();

    if (observation.yaw_known) {
        const double turn = 2 * std::numbers::pi / observation.like_turns;
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
    track.spread = track.covariance.topLeftCorner<2, 2>().trace();
    ++track.sightings;
    std::erase_if(track.sources, [&](const auto& s) { return s.first == camera; });
    track.sources.emplace_back(camera, time);
}

void Smoother::start(Nanoseconds time, const std::string& camera, const PoseObservation& observation) {
    Track track;
    track.robot = observation.robot;
    track.time = track.born = time;
    track.state.head<2>() = Eigen::Vector2d(observation.pose.x, observation.pose.y);
    track.covariance.topLeftCorner<2, 2>() = observation.covariance.topLeftCorner<2, 2>();
    track.covariance.bottomRightCorner<2, 2>() = Eigen::Matrix2d::Identity();  // up to about 1 m/s in any direction
    update(track, time, camera, observation);
    track.sightings = 1;
    tracks_.push_back(track);
}

void Smoother::add(Nanoseconds time, const std::string& camera, const std::vector<PoseObservation>& observations) {
    for (Track& track : tracks_) {
        if (to_seconds(track.time - time) > settings_.coast) {
            ++late_;
            return;
        }
        predict(track, time);
    }
    std::erase_if(tracks_, [&](const Track& t) { return to_seconds(time - t.seen) > (t.name.empty() ? 2 * settings_.ok : settings_.forget); });

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
        if (!used[o]) start(time, camera, observations[o]);
    }
    for (std::size_t t = 0; t < track_used.size(); ++t) {
        const bool watched = std::any_of(tracks_[t].sources.begin(), tracks_[t].sources.end(), [&](const auto& s) { return s.first == camera; });
        if (watched) tracks_[t].presence += 0.15 * ((track_used[t] ? 1 : 0) - tracks_[t].presence);
    }
    drop_doubles();
    confirm(time);
}

/// Of two tracks of like robots that stand inside each other, the one that is seen less is the other's shadow.
void Smoother::drop_doubles() {
    std::vector<bool> shadows(tracks_.size(), false);
    for (std::size_t a = 0; a < tracks_.size(); ++a) {
        const double reach = 2.4 * half_size(robots_[static_cast<std::size_t>(tracks_[a].robot)].shape).x();
        for (std::size_t b = 0; b < tracks_.size() && tracks_[a].presence < 0.6; ++b) {
            shadows[a] = shadows[a] || (tracks_[b].robot == tracks_[a].robot && tracks_[b].presence > tracks_[a].presence &&
                                        (tracks_[b].state.head<2>() - tracks_[a].state.head<2>()).norm() < reach);
        }
    }
    std::size_t kept = 0;
    for (std::size_t i = 0; i < tracks_.size(); ++i) {
        if (!shadows[i]) std::swap(tracks_[kept++], tracks_[i]);
    }
    tracks_.erase(tracks_.begin() + static_cast<std::ptrdiff_t>(kept), tracks_.end());
}

/// How long a track is believed without being seen, s.
double Smoother::patience(const Track& track) const { return std::min(settings_.coast, to_seconds(track.seen - track.born)); }

/// How long a robot must be unseen at its old place to be believed at a new one, s: not at all where the new one is far surer, and
/// longer where it is far less sure.
double Smoother::patience_with(const Track& old, const Track& fresh) const {
    const double doubt = fresh.spread / old.spread;
    return doubt < 0.1 ? 0 : doubt > 4 ? settings_.forget : settings_.ok;
}

/// Gives names to tracks that were seen often enough. A robot of which there is only one is believed at a new place when it
/// is seen there again and no longer at the old one.
void Smoother::confirm(Nanoseconds time) {
    for (std::size_t t = 0; t < tracks_.size(); ++t) {
        Track& track = tracks_[t];
        if (!track.name.empty()) continue;
        const auto index = static_cast<std::size_t>(track.robot);
        const SiteRobot& robot = robots_[index];
        if (robot.many) {
            if (track.sightings >= settings_.confirmations) track.name = robot.id + "-" + std::to_string(++names_given_[index]);
            continue;
        }
        const auto old = std::find_if(tracks_.begin(), tracks_.end(), [&](const Track& other) { return other.name == robot.id; });
        if (old == tracks_.end()) {
            track.name = robot.id;
        } else if (track.sightings >= settings_.confirmations && to_seconds(time - old->seen) >= patience_with(*old, track)) {
            track.name = robot.id;
            old->name.clear();
            old->sightings = 0;  // it must be seen anew to be believed again
        }
    }
}

std::optional<PoseObservation> Smoother::expected(int robot, Nanoseconds time) const {
    for (Track track : tracks_) {
        if (track.robot != robot || track.name.empty() || to_seconds(time - track.seen) > patience(track)) continue;
        predict(track, std::max(time, track.time));
        PoseObservation expected{robot, {track.state.x(), track.state.y(), wrap_angle(track.yaw)}, track.yaw_known};
        expected.covariance.setZero();
        expected.covariance.topLeftCorner<2, 2>() = track.covariance.topLeftCorner<2, 2>();
        expected.covariance(2, 2) = track.yaw_known ? track.yaw_variance : std::numbers::pi * std::numbers::pi / 3;
        return expected;
    }
    return std::nullopt;
}

std::vector<Fix> Smoother::fixes(Nanoseconds time) const {
    std::vector<Fix> fixes;
    for (Track track : tracks_) {
        if (track.name.empty()) continue;
        predict(track, std::max(time, track.time));
        const double unseen = to_seconds(time - track.seen);
        if (unseen > patience(track)) continue;
        Fix fix;
        fix.time = time;
        fix.robot = track.name;
        fix.status = unseen > settings_.ok ? FixStatus::coasting : FixStatus::ok;
        fix.pose = {track.state.x(), track.state.y(), wrap_angle(track.yaw)};
        fix.yaw_known = track.yaw_known;
        fix.covariance.setZero();
        fix.covariance.topLeftCorner<2, 2>() = track.covariance.topLeftCorner<2, 2>();
        fix.covariance(2, 2) = track.yaw_known ? track.yaw_variance : std::numbers::pi * std::numbers::pi / 3;
        for (const auto& [camera, seen] : track.sources) {
            if (to_seconds(time - seen) < settings_.ok) fix.sources.push_back(camera);
        }
        fixes.push_back(fix);
    }
    return fixes;
}

}  // namespace roomfix
