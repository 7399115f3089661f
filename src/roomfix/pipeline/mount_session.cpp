#include "roomfix/pipeline/mount_session.hpp"

#include <fmt/format.h>

#include "roomfix/ceiling/ceiling_observer.hpp"
#include "roomfix/ceiling/robot_locator.hpp"
#include "roomfix/connect/frame_source.hpp"
#include "roomfix/connect/odometry_source.hpp"
#include "roomfix/pipeline/camera/landmark_camera.hpp"

namespace roomfix {

namespace {

/// The robot's wheels; what is known of them goes into the settings.
Result<OdometryTrack> wheels_of(const Site& site, int robot, const std::string& file, MountSettings& settings) {
    OdometryTrack track;
    if (file.empty()) return track;
    const auto batch = load_odometry(file, site, robot);
    if (!batch) return batch.error();
    for (const OdometryObservation& o : batch->poses) {
        if (o.robot == robot) track.add(o.time, o.pose);
    }
    if (const auto& known = site.robots[static_cast<std::size_t>(robot)].odometry) {
        settings.scale_sigma = known->scale_sigma;
        settings.drift_sigma = known->drift_sigma;
    }
    return track;
}

}  // namespace

Result<MountCalibration> calibrate_mount_from(const Site& site, const SiteCamera& camera, const std::string& source, const std::string& odometry,
                                              MountSettings settings, const std::function<void(double)>& progress) {
    SiteCamera free = camera;  // its mount may be far off: landmarks are taken as they come
    if (auto* mount = std::get_if<Mount>(&free.placement)) mount->has_covariance = false;
    auto looking = LandmarkCamera::create(site, free);
    if (!looking) return looking.error();
    const auto wheels = wheels_of(site, looking->robot(), odometry, settings);
    if (!wheels) return wheels.error();
    auto frames = open_source(source);
    if (!frames) return frames.error();
    if ((*frames)->live()) return Error{fmt::format("{}: a mount is calibrated from a recording: record the turn first", source)};
    std::vector<MountFrame> seen;
    SourceFrame frame;
    constexpr int most_bad = 100;  // a source that gives nothing else is not asked for ever
    int bad = 0;
    for (double number = 1;; ++number) {
        const auto more = (*frames)->next(frame);
        if (!more) {  // a damaged picture costs itself only
            if (++bad > most_bad) return more.error();
            continue;
        }
        if (!*more) break;
        if (frame.image.width() != camera.model.width || frame.image.height() != camera.model.height) {
            return Error{fmt::format("{}: the frame is {} x {} pixels, camera {} has {} x {}: record it with the same settings", frame.name,
                                     frame.image.width(), frame.image.height(), camera.id, camera.model.width, camera.model.height)};
        }
        looking->look(frame.image, {});
        if (!looking->located().places.empty()) seen.push_back({looking->seen_points(), looking->located().places[0].pose, frame.time});
        if (progress && (*frames)->count() > 0) progress(number / static_cast<double>((*frames)->count()));
    }
    return calibrate_mount(camera_on_robot(camera, std::get<Mount>(camera.placement)), std::move(seen), settings, *wheels);
}

}  // namespace roomfix
