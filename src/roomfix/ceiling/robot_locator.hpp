// Which landmarks were seen, and where that puts the robot: one code path for landmarks, ranges, and both.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "roomfix/ceiling/floor_fit.hpp"
#include "roomfix/observation/landmark_observation.hpp"
#include "roomfix/observation/range_observation.hpp"
#include "roomfix/site/site.hpp"

namespace roomfix {

/// What is known besides the picture and the ranges.
struct LocatorHints {
    int landmark = -1;  // index in the site: this one is seen
    struct Prediction {
        Pose2 pose;
        Eigen::Matrix3d covariance;
    };
    std::optional<Prediction> prediction;     // only tells hypotheses apart; it is not mixed into the fix
    std::span<const Eigen::Vector2d> places;  // m: where the robot may be, for ranges without a landmark
};

struct LocatorSettings {
    LateModel late;
    double gate = 4;                // px: a landmark seen this far from where it should be is another one
    double unexplained = 12;        // log-likelihood that a landmark in the picture costs which a pose does not explain
    double least_weight = 1e-3;     // of a hypothesis
    double largest_sigma = 1.5;     // m: a place known less is no fix
    std::size_t most_refined = 64;  // hypotheses that are worked out
};

/// One place where the robot may be.
struct RobotPlace {
    Pose2 pose;
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();
    bool yaw_known = false;
    double weight = 1;
    double pixel_rms = 0;                         // px
    FixedList<std::pair<int, int>, 8> landmarks;  // (index of the observation, index of the landmark)
};

struct LocatedRobot {
    std::vector<RobotPlace> places;  // the best first; weights add up to 1
    std::string reason;              // why there is none
};

class RobotLocator {
public:
    /// `camera` may be missing where only ranges count.
    RobotLocator(const Site& site, int robot, std::optional<CameraOnRobot> camera, const LocatorSettings& settings = {});

    /// Every landmark that an observation may be gives a hypothesis; other observations, ranges and the prediction weigh it. Ranges
    /// must be about as old as the picture.
    void locate(std::span<const LandmarkObservation> landmarks, std::span<const RangeObservation> ranges, const LocatorHints& hints, LocatedRobot& result);

    /// What the fit of a place rests on: the points of the landmarks that it explains.
    std::vector<SeenPoint> seen_points(std::span<const LandmarkObservation> landmarks, const RobotPlace& place) const;

private:
    struct Hypothesis {
        double score;
        RobotPlace place;
    };
    void hear(const RangeObservation& range);
    void propose(std::span<const LandmarkObservation> landmarks, const LocatorHints& hints);
    Pose2 pose_of(const LandmarkObservation& seen, int landmark) const;
    Pose2 laid_onto(const LandmarkObservation& seen, const std::vector<Eigen::Vector3d>& points) const;
    std::optional<Pose2> pose_before_tag(const LandmarkObservation& seen, const SiteLandmark& tag) const;
    void explain(const Pose2& pose, std::span<const LandmarkObservation> landmarks, const LocatorHints& hints, RobotPlace& place) const;
    double hint_likelihood(const Pose2& pose, const LocatorHints& hints) const;
    void collect(std::span<const LandmarkObservation> landmarks, const RobotPlace& place, std::vector<SeenPoint>& points) const;
    bool refine(std::span<const LandmarkObservation> landmarks, const LocatorHints& hints, Hypothesis& hypothesis);

    std::vector<SiteLandmark> landmarks_;
    std::vector<std::vector<Eigen::Vector3d>> points_;  // of each landmark, map
    std::vector<LandmarkShape> shapes_;
    std::vector<SiteBeacon> beacons_;
    std::vector<Receiver> receivers_;  // at least one
    int robot_;
    std::optional<CameraOnRobot> camera_;
    LocatorSettings settings_;
    std::vector<HeardRange> heard_;
    std::vector<SeenPoint> seen_;
    std::vector<Hypothesis> hypotheses_;
};

}  // namespace roomfix
