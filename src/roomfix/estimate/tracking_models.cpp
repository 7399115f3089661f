#include "roomfix/estimate/tracking_models.hpp"

#include <algorithm>

namespace roomfix {

TrackingModels::TrackingModels(const Site& described, const TrackerSettings& wanted) : site(described), settings(wanted) {
    for (const SiteRobot& robot : site.robots) {
        MotionModel model = settings.motion;
        if (robot.drive != Drive::unknown) model.drive = robot.drive;
        motion.push_back(model);
        auto& heard = receivers.emplace_back();
        for (const Receiver& receiver : robot.receivers.empty() ? std::vector{somewhere_on(robot)} : robot.receivers) {
            RangeSource source;
            source.number = static_cast<int>(heard.size());
            source.receiver = receiver.position;
            source.receiver_sigma = receiver.position_sigma;
            source.bias_sigma = receiver.bias_sigma;
            source.own_sigma = own_part * receiver.bias_sigma;
            source.stretch.scale = receiver.scale_sigma;
            heard.push_back(source);
        }
        for (RangeSource& source : heard) {
            if (heard.size() > 1 && source.receiver_sigma.isZero(0)) source.receiver_sigma.head<2>().setConstant(settings.receiver_place);
            source.late = settings.late;
            source.bias_memory = settings.range_bias_memory;
            source.wander_way = settings.wander_way;
        }
        const Detector detector = robot.detector.value_or(Detector{});
        detectors.emplace_back().wander_way = settings.wander_way;
        detectors.back().position = detector.position.head<2>();
        detectors.back().position_sigma = detector.position_sigma.head<2>();
        detectors.back().bias_memory = settings.range_bias_memory;
        wheels.push_back(settings.odometry);
        odometry.push_back(robot.odometry ? OdometryPrior{robot.odometry->scale_sigma, robot.odometry->turn_scale_sigma, robot.odometry->drift_sigma}
                                          : OdometryPrior{});
        driven.emplace_back(settings.odometry_limits);
    }
    range_source = source("ranges");
    wheel_source = source("odometry");
    sighting_source = source("sightings");
    shapes = landmark_shapes(site.landmarks);
    for (const SiteLandmark& landmark : site.landmarks) {
        landmark_points.push_back(map_points(landmark));
        marks.push_back({landmark.map_from_landmark.translation().head<2>(), landmark.sigma, std::holds_alternative<PointMark>(landmark.kind)});
    }
    for (const SiteCamera& camera : site.cameras) {
        const int number = source(camera.id);
        if (const auto* mount = std::get_if<Mount>(&camera.placement)) {
            OnboardSource errors = onboard_source(number, camera_on_robot(camera, *mount));
            errors.time_offset_sigma = camera.time_offset_sigma;
            errors.readout = camera.capture.readout;
            onboard.emplace(number, errors);
        } else if (const auto view = fixed_view(camera)) {
            fixed[number].calibrated_exactly = view->calibration.isZero(0);
            fixed[number].time_offset_sigma = camera.time_offset_sigma;
            fixed[number].readout = camera.capture.readout;
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
    errors.body_memory = settings.body_memory;
    fixed.emplace(number, errors);
    return number;
}

void TrackingModels::learn(int robot, const SenseNoise& noise) {
    const auto r = static_cast<std::size_t>(robot);
    for (RangeSource& source : receivers[r]) source = learned(source, noise.receiver);
    detectors[r] = learned(detectors[r], noise);
    wheels[r] = learned(wheels[r], noise);
    motion[r] = learned(motion[r], noise);
}

bool TrackingModels::has_mark(int robot) const {
    const auto r = static_cast<std::size_t>(robot);
    const SiteRobot& known = site.robots[r];
    return known.odometry || known.receiver() || known.detector || known.tag || !driven[r].empty() ||
           std::any_of(site.cameras.begin(), site.cameras.end(), [&](const SiteCamera& camera) {
               const auto* mount = std::get_if<Mount>(&camera.placement);
               return mount && mount->robot == known.id;
           });
}

}  // namespace roomfix
