#include "roomfix/pipeline/site_calibration.hpp"

#include <algorithm>
#include <cmath>

#include "roomfix/base/decompositions.hpp"
#include "roomfix/calibrate/floor.hpp"
#include "roomfix/calibrate/mount.hpp"

namespace roomfix {
namespace {

/// Means are spread as widely as the errors were before, less what is left of them.
double surprise_of(const SixErrors& errors) {
    constexpr double learned_little = 0.05;  // of a variance of 1
    const auto spread = symmetric_eigen(Matrix6d::Identity() - errors.covariance);
    double most = 0;
    for (int i = 0; i < 6; ++i) {
        const double variance = spread.eigenvalues()[i];
        if (variance > learned_little) most = std::max(most, std::abs(spread.eigenvectors().col(i).dot(errors.mean)) / std::sqrt(variance));
    }
    return most;
}

/// Puts what was learned into a placement.
void take(const LearnedCalibration& learned, UncertainPose3& pose, bool& has_covariance, PoseByIntrinsics& by_intrinsics) {
    pose = {perturbed(pose.pose, learned.pose), learned.pose_covariance};
    has_covariance = !learned.pose_covariance.isZero(0);  // a pose typed in by hand stays exact where only the lens was learned
    by_intrinsics = learned.errors.pose_by;
}

SiteCalibration calibrated(const TrackingModels& models, const SixErrors& errors) {
    SiteCalibration result;
    result.camera = *models.site.camera(models.source_name(errors.source));
    result.sightings = errors.sightings;
    result.surprise = surprise_of(errors);
    SiteCamera& camera = result.camera;
    LearnedCalibration learned;
    if (auto* mount = std::get_if<Mount>(&camera.placement)) {
        const CalibrationRoot& root = models.onboard.at(errors.source).calibration;
        learned = learned_calibration(mount->robot_from_camera.covariance, camera.intrinsics_errors(), root, errors.mean, errors.covariance);
        result.error_before = tilt_error(joint_covariance(mount->robot_from_camera.covariance, camera.intrinsics_errors()).topLeftCorner<6, 6>());
        take(learned, mount->robot_from_camera, mount->has_covariance, mount->by_intrinsics);
    } else {
        const View& view = models.views.at(errors.source);
        KnownPose pose = *known_pose(camera);
        learned = learned_calibration(pose.map_from_camera.covariance, {camera.intrinsics_covariance, pose.by_intrinsics}, view.calibration, errors.mean,
                                      errors.covariance);
        result.error_before = floor_error(view);
        take(learned, pose.map_from_camera, pose.has_covariance, pose.by_intrinsics);
        camera.placement = pose;
    }
    result.moved = learned.pose;
    result.covariance = joint_covariance(learned.pose_covariance, learned.errors).topLeftCorner<6, 6>();
    if (!camera.intrinsics_covariance.isZero(0)) {
        camera.model.set_intrinsics(camera.model.intrinsics() + learned.intrinsics);
        camera.intrinsics_covariance = learned.errors.covariance;
    }
    const bool rides = std::holds_alternative<Mount>(camera.placement);
    result.error_now = rides ? tilt_error(result.covariance) : floor_error(*fixed_view(camera));
    return result;
}

}  // namespace

std::vector<SiteCalibration> calibrated_cameras(const TrackingModels& models, const std::vector<SixErrors>& errors) {
    std::vector<SiteCalibration> cameras;
    for (const SixErrors& six : errors) cameras.push_back(calibrated(models, six));
    return cameras;
}

}  // namespace roomfix
