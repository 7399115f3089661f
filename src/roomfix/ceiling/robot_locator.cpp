#include "roomfix/ceiling/robot_locator.hpp"

#include <algorithm>
#include <cmath>

#include "roomfix/base/decompositions.hpp"

namespace roomfix {

RobotLocator::RobotLocator(const Site& site, int robot, std::optional<CameraOnRobot> camera, const LocatorSettings& settings)
    : landmarks_(site.landmarks),
      shapes_(landmark_shapes(site.landmarks)),
      beacons_(site.beacons),
      receivers_(site.robots[static_cast<std::size_t>(robot)].receivers),
      robot_(robot),
      camera_(std::move(camera)),
      settings_(settings) {
    if (receivers_.empty()) receivers_.push_back(somewhere_on(site.robots[static_cast<std::size_t>(robot)]));
    for (const SiteLandmark& landmark : landmarks_) points_.push_back(map_points(landmark));
}

void RobotLocator::locate(std::span<const LandmarkObservation> landmarks, std::span<const RangeObservation> ranges, const LocatorHints& hints,
                          LocatedRobot& result) {
    result.places.clear();
    result.reason.clear();
    heard_.clear();
    for (const RangeObservation& range : ranges) {
        if (range.robot == robot_) hear(range);
    }
    propose(landmarks, hints);
    std::stable_sort(hypotheses_.begin(), hypotheses_.end(), [](const Hypothesis& a, const Hypothesis& b) { return a.score > b.score; });
    if (hypotheses_.size() > settings_.most_refined) hypotheses_.resize(settings_.most_refined);
    std::erase_if(hypotheses_, [&](Hypothesis& h) { return !refine(landmarks, hints, h); });
    std::stable_sort(hypotheses_.begin(), hypotheses_.end(), [](const Hypothesis& a, const Hypothesis& b) { return a.score > b.score; });

    double sum = 0;
    for (Hypothesis& h : hypotheses_) {
        const double weight = std::exp(h.score - hypotheses_[0].score);
        const auto same = [&](const RobotPlace& other) {
            const double turn = h.place.yaw_known ? std::remainder(other.pose.yaw - h.place.pose.yaw, 2 * std::numbers::pi) : 0;
            return std::hypot(other.pose.x - h.place.pose.x, other.pose.y - h.place.pose.y) < 0.02 && std::abs(turn) < 0.05;
        };
        if (weight < settings_.least_weight || std::any_of(result.places.begin(), result.places.end(), same)) continue;
        h.place.weight = weight;
        sum += weight;
        result.places.push_back(h.place);
    }
    for (RobotPlace& place : result.places) place.weight /= sum;
    if (!result.places.empty()) return;
    result.reason = landmarks.empty() && heard_.empty() ? "no landmark and no range"
                                                        : "what was seen and heard does not fix a place: one landmark, or ranges to three beacons, would";
}

/// A pose for each landmark that an observation may be, and the places that were given.
/// A range counts as no better than the receiver's own place is known.
void RobotLocator::hear(const RangeObservation& range) {
    const Receiver& receiver = receivers_[std::min(static_cast<std::size_t>(range.receiver), receivers_.size() - 1)];
    const double sigma = std::hypot(range.sigma, receiver.position_sigma.maxCoeff());
    heard_.push_back({beacons_[static_cast<std::size_t>(range.beacon)].position, range.range, sigma, receiver.position});
}

void RobotLocator::propose(std::span<const LandmarkObservation> landmarks, const LocatorHints& hints) {
    hypotheses_.clear();
    const auto add = [&](const Pose2& pose) {
        Hypothesis h{hint_likelihood(pose, hints), {}};
        h.place.pose = pose;
        explain(pose, landmarks, hints, h.place);
        h.score -= settings_.unexplained * static_cast<double>(landmarks.size() - h.place.landmarks.size());
        FloorEvidence ranges{.ranges = heard_, .late = settings_.late};
        h.score += range_score(ranges, pose);
        hypotheses_.push_back(h);
    };
    for (const LandmarkObservation& seen : landmarks) {
        for (const int shape : seen.shapes) {
            for (const int landmark : shapes_[static_cast<std::size_t>(shape)].landmarks) {
                if (hints.landmark >= 0 && landmark != hints.landmark && landmarks.size() == 1) continue;
                if (camera_) add(pose_of(seen, landmark));
            }
        }
    }
    if (!landmarks.empty()) return;
    for (const Eigen::Vector2d& place : hints.places) add({place.x(), place.y(), hints.prediction ? hints.prediction->pose.yaw : 0});
}

/// The pose that one observation alone gives. A tag may hang anywhere: what its corners say of the whole camera is a start, and so is
/// their place at their height; the better fit counts.
Pose2 RobotLocator::pose_of(const LandmarkObservation& seen, int landmark) const {
    const SiteLandmark& known = landmarks_[static_cast<std::size_t>(landmark)];
    const auto& points = points_[static_cast<std::size_t>(landmark)];
    const Pose2 laid = laid_onto(seen, points);
    if (!std::holds_alternative<Tag>(known.kind)) return laid;
    std::vector<SeenPoint> corners;
    for (std::size_t i = 0; i < seen.points.size(); ++i) corners.push_back({points[i], seen.points[i].pixel, seen.points[i].covariance, 0, 0});
    Pose2 best = laid;
    double least = 1e300;
    for (const auto& start : {std::optional(laid), pose_before_tag(seen, known)}) {
        if (!start) continue;
        const auto fit = fit_on_floor({.camera = &*camera_, .points = corners}, *start);
        if (!fit || fit->pixel_rms >= least) continue;
        least = fit->pixel_rms;
        best = fit->pose;
    }
    return best;
}

/// The observation's points where they lie at their landmark's height, laid onto the landmark.
Pose2 RobotLocator::laid_onto(const LandmarkObservation& seen, const std::vector<Eigen::Vector3d>& points) const {
    FixedList<Eigen::Vector2d, 4> in_robot, in_map;
    for (std::size_t i = 0; i < seen.points.size(); ++i) {
        const auto place = point_at_height(*camera_, seen.points[i].pixel, points[i].z());
        if (!place) continue;
        in_robot.push_back(*place);
        in_map.push_back(points[i].head<2>());
    }
    return align({in_robot.begin(), in_robot.end()}, {in_map.begin(), in_map.end()});
}

/// A tag's four corners give the camera's whole pose before it, on a wall, too: what of that lies on the floor.
std::optional<Pose2> RobotLocator::pose_before_tag(const LandmarkObservation& seen, const SiteLandmark& tag) const {
    const auto own = own_points(tag.kind);
    std::vector<FloorPoint> corners;
    for (std::size_t i = 0; i < own.size(); ++i) corners.push_back({seen.points[i].pixel, own[i].head<2>()});
    const auto tag_from_camera = camera_pose_from_floor_points(camera_->model, corners, 0.1);
    if (!tag_from_camera) return std::nullopt;
    const Eigen::Isometry3d placed = tag.map_from_landmark * tag_from_camera->map_from_camera.pose * camera_->robot_from_camera.pose.inverse();
    const Eigen::Vector3d forward = placed.linear().col(0);
    return Pose2{placed.translation().x(), placed.translation().y(), std::atan2(forward.y(), forward.x())};
}

/// Which landmark each observation is if the robot is at `pose`.
void RobotLocator::explain(const Pose2& pose, std::span<const LandmarkObservation> landmarks, const LocatorHints& hints, RobotPlace& place) const {
    place.landmarks.clear();
    for (std::size_t o = 0; o < landmarks.size() && camera_; ++o) {
        int best = -1;
        double nearest = settings_.gate;
        for (const int shape : landmarks[o].shapes) {
            for (const int landmark : shapes_[static_cast<std::size_t>(shape)].landmarks) {
                double worst = 0;
                for (std::size_t i = 0; i < landmarks[o].points.size() && worst < nearest; ++i) {
                    const auto pixel = predict_point(*camera_, pose, points_[static_cast<std::size_t>(landmark)][i]);
                    worst = pixel ? std::max(worst, (landmarks[o].points[i].pixel - *pixel).norm()) : 1e9;
                }
                if (worst < nearest) {
                    nearest = worst;
                    best = landmark;
                }
            }
        }
        if (best >= 0 && place.landmarks.size() < place.landmarks.capacity()) place.landmarks.push_back({static_cast<int>(o), best});
    }
    // Where it is said which landmark is seen, a pose that sees only others is none.
    const auto is_named = [&](const auto& match) { return match.second == hints.landmark; };
    if (hints.landmark >= 0 && std::none_of(place.landmarks.begin(), place.landmarks.end(), is_named)) place.landmarks.clear();
}

double RobotLocator::hint_likelihood(const Pose2& pose, const LocatorHints& hints) const {
    if (!hints.prediction) return 0;
    const Pose2& expected = hints.prediction->pose;
    const Eigen::Vector3d off(pose.x - expected.x, pose.y - expected.y, wrap_angle(pose.yaw - expected.yaw));
    return -0.5 * off.dot(hints.prediction->covariance.inverse() * off);
}

void RobotLocator::collect(std::span<const LandmarkObservation> landmarks, const RobotPlace& place, std::vector<SeenPoint>& points) const {
    points.clear();
    int group = 0;
    for (const auto& [observation, landmark] : place.landmarks) {
        const auto& known = points_[static_cast<std::size_t>(landmark)];
        const LandmarkObservation& seen = landmarks[static_cast<std::size_t>(observation)];
        for (std::size_t i = 0; i < seen.points.size(); ++i) {
            points.push_back({known[i], seen.points[i].pixel, seen.points[i].covariance, group, landmarks_[static_cast<std::size_t>(landmark)].sigma});
        }
        ++group;
    }
}

std::vector<SeenPoint> RobotLocator::seen_points(std::span<const LandmarkObservation> landmarks, const RobotPlace& place) const {
    std::vector<SeenPoint> points;
    collect(landmarks, place, points);
    return points;
}

/// The joint fit of everything that the hypothesis explains.
bool RobotLocator::refine(std::span<const LandmarkObservation> landmarks, const LocatorHints& hints, Hypothesis& h) {
    collect(landmarks, h.place, seen_);
    if (seen_.empty() && !landmarks.empty()) return false;
    const FloorEvidence evidence{camera_ ? &*camera_ : nullptr, seen_, heard_, settings_.late};
    const auto fit = fit_on_floor(evidence, h.place.pose);
    if (!fit || fit->covariance.topLeftCorner<2, 2>().trace() > settings_.largest_sigma * settings_.largest_sigma) return false;
    h.place.pose = fit->pose;
    h.place.covariance = fit->covariance;
    h.place.yaw_known = fit->yaw_known;
    h.place.pixel_rms = fit->pixel_rms;
    // The pixels' own misfit says little about which landmark it is (they look alike) and much about the lens: it is left out.
    h.score = range_score(evidence, fit->pose) + hint_likelihood(fit->pose, hints) -
              settings_.unexplained * static_cast<double>(landmarks.size() - h.place.landmarks.size());
    return true;
}

}  // namespace roomfix
