#include "roomfix/pipeline/camera/sighting.hpp"

#include "roomfix/estimate/tracker.hpp"

namespace roomfix {

void set_time_error(Sighting& sighting, const TimeError& error) {
    for (PoseObservation& pose : sighting.poses) pose.time_error = error;
    for (TagSighting& tag : sighting.tags) tag.time_error = error;
    if (sighting.landmarks) {
        for (LandmarkObservation& landmark : sighting.landmarks->landmarks) landmark.time_error = error;
    }
    if (sighting.corners) {
        for (CornerObservation& corner : sighting.corners->corners) corner.time_error = error;
    }
}

void feed(Tracker& tracker, Nanoseconds time, const std::string& camera, const Sighting& sighting) {
    if (sighting.sees_all || !sighting.poses.empty()) tracker.observe(time, camera, sighting.poses);
    for (const AbsenceObservation& absence : sighting.absent) tracker.observe(time, camera, absence);
    for (const TagSighting& tag : sighting.tags) tracker.observe(time, camera, tag);
    if (sighting.landmarks) tracker.observe(time, camera, *sighting.landmarks);
    if (sighting.corners) tracker.observe(time, camera, *sighting.corners);
}

std::vector<Fix> fixes_of(const Sighting& sighting, const Site& site, Nanoseconds time, const std::vector<std::string>& sources) {
    std::vector<Fix> fixes;
    for (const SeenRobot& seen : sighting.robots) {
        Fix& fix = fixes.emplace_back();
        fix.time = time;
        if (seen.robot >= 0) fix.robot = site.robots[static_cast<std::size_t>(seen.robot)].id;
        fix.status = FixStatus::ok;
        fix.pose = seen.pose;
        fix.yaw_known = seen.yaw_known;
        fix.covariance = seen.covariance;
        fix.sources = sources;
        fix.hypotheses = seen.hypotheses;
        fix.map_from_camera = seen.map_from_camera;
        fix.existence = seen.existence;
    }
    if (fixes.empty()) {
        Fix& none = fixes.emplace_back();
        none.time = time;
        none.reason = sighting.reason;
    }
    return fixes;
}

}  // namespace roomfix
