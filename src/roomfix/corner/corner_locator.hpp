// Which corner was seen, and where that puts the camera and the robot under it.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "roomfix/corner/corner_observer.hpp"
#include "roomfix/geometry/pose.hpp"
#include "roomfix/observation/corner_observation.hpp"
#include "roomfix/observation/range_noise.hpp"
#include "roomfix/observation/range_observation.hpp"
#include "roomfix/site/site.hpp"

namespace roomfix {

/// What is known besides the picture. None of it is mixed into the pose: it only tells explanations apart.
struct CameraHints {
    int corner = -1;  // index in the site: this one is seen
    struct Heading {
        double yaw = 0;      // rad, of the optical axis seen from above
        double sigma = 0.2;  // rad
    };
    std::optional<Heading> heading;
    struct Prediction {
        Pose2 pose;  // of the robot
        Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();
    };
    std::optional<Prediction> prediction;
    std::span<const RangeObservation> ranges;  // of the same robot, about as old as the picture
};

struct CornerLocatorSettings {
    double unknown_tilt = 0.026;  // rad: how far a mount without a covariance may be off
    double least_weight = 1e-3;   // of a place
    double largest_misfit = 30;   // chi-square of what is seen against the mount: beyond, it is another corner
    LateModel late;
};

/// One place where the camera may be.
struct CameraPlace {
    UncertainPose3 map_from_camera;
    Pose2 pose;             // of the robot; where the camera stands alone, of the camera: yaw is then the optical axis seen from above
    bool yaw_known = true;  // not of a camera that looks straight up
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();
    double weight = 1;
    int corner = 0;       // index in the site
    int observation = 0;  // index of what was seen
    int sighting = 0;     // of that observation
    double depth = 0;     // m: of what was seen below the site's corner, where that has a moulding
};

struct LocatedCamera {
    std::vector<CameraPlace> places;  // the likeliest first; weights add up to 1
    double best_corner = 0;           // weight of all readings of the corner on which the best one rests; the covariance of each contains the others
    std::string reason;               // why there is none
};

class CornerLocator {
public:
    /// A camera of known height, or one that is mounted on a robot. An error for any other, or if the site has no corners.
    static Result<CornerLocator> for_camera(const Site& site, const SiteCamera& camera, const CornerLocatorSettings& settings = {});

    /// Index of the robot that carries the camera, -1: none.
    int robot() const { return robot_; }
    /// The angles between walls that the site has, rad, each once.
    std::vector<double> wall_angles() const;

    /// Where corners should be seen, for the observer.
    CornerHints expected(const CameraHints& hints) const;
    /// Every corner of the site that an observation may be is a place; hints and walls weigh it.
    void locate(std::span<const CornerObservation> seen, const CameraHints& hints, LocatedCamera& result) const;

private:
    CornerLocator(const Site& site, const SiteCamera& camera, const CornerLocatorSettings& settings) : site_(site), camera_(camera), settings_(settings) {}
    double height() const;
    std::optional<CameraPlace> stand_at(const CornerObservation& seen, const SiteCorner& corner, double& misfit) const;
    std::optional<CameraPlace> on_tripod(const CornerObservation& seen, const SiteCorner& corner, const KnownHeight& known) const;
    std::optional<CameraPlace> on_robot(const CornerObservation& seen, const SiteCorner& corner, const Mount& mount, double& misfit) const;
    double hint_likelihood(const CameraPlace& place, const CameraHints& hints) const;
    CornerView view_of(const Eigen::Isometry3d& map_from_camera, const SiteCorner& corner) const;

    Site site_;
    SiteCamera camera_;
    CornerLocatorSettings settings_;
    int robot_ = -1;
};

}  // namespace roomfix
