#include "roomfix/estimate/tracking_models.hpp"

#include <algorithm>

namespace roomfix {

TrackingModels::TrackingModels(const Site& described, const TrackerSettings& wanted) : site(described), settings(wanted) {
    for (const SiteRobot& robot : site.robots) {
        MotionModel model = settings.motion;
        if (robot.drive != Drive::unknown) model.drive = robot.drive;
        motion.push_back(model);
        RangeSource source{Eigen::Vector3d::Zero(), settings.late, 0, 0, settings.range_bias_memory};
        if (robot.receiver) {
            source.receiver = robot.receiver->position;
            source.bias_sigma = robot.receiver->bias_sigma;
            source.scale_sigma = robot.receiver->scale_sigma;
        }
        ranges.push_back(source);
        odometry.push_back(robot.odometry ? OdometryPrior{robot.odometry->scale_sigma, robot.odometry->drift_sigma} : OdometryPrior{});
        driven.emplace_back(settings.odometry_limits);
    }
    range_source = source("ranges");
    wheel_source = source("odometry");
    shapes = landmark_shapes(site.landmarks);
    for (const SiteLandmark& landmark : site.landmarks) landmark_points.push_back(map_points(landmark));
    for (const SiteCamera& camera : site.cameras) {
        const int number = source(camera.id);
        if (const auto* mount = std::get_if<Mount>(&camera.placement)) {
            OnboardSource errors = onboard_source(number, camera_on_robot(camera, *mount));
            errors.time_offset_sigma = camera.time_offset_sigma;
            onboard.emplace(number, errors);
        } else if (const auto view = fixed_view(camera)) {
            fixed[number].calibrated_exactly = view->calibration.isZero(0);
            fixed[number].time_offset_sigma = camera.time_offset_sigma;
            views.emplace(number, *view);
        }
    }
}

int TrackingModels::source(const std::string& name) {
    const auto found = std::find(source_names.begin(), source_names.end(), name);
    if (found != source_names.end()) return static_cast<int>(found - source_names.begin());
    source_names.push_back(name);
    const int number = static_cast<int>(source_names.size()) - 1;
    PoseSource errors;
    errors.source = number;
    if (name.find('+') != std::string::npos) {
        errors.calibrated_exactly = false;
        errors.calibration_memory = settings.body_memory;
    }
    fixed.emplace(number, errors);
    return number;
}

bool TrackingModels::has_mark(int robot) const {
    const auto r = static_cast<std::size_t>(robot);
    const SiteRobot& known = site.robots[r];
    return known.odometry || known.receiver || known.tag || !driven[r].empty() ||
           std::any_of(site.cameras.begin(), site.cameras.end(), [&](const SiteCamera& camera) {
               const auto* mount = std::get_if<Mount>(&camera.placement);
               return mount && mount->robot == known.id;
           });
}

}  // namespace roomfix
