// The site as the tracker needs it: how each robot moves and how each sensor measures.
#pragma once

#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include "roomfix/estimate/corner_model.hpp"
#include "roomfix/estimate/odometry_track.hpp"
#include "roomfix/estimate/pose_model.hpp"
#include "roomfix/estimate/range_model.hpp"
#include "roomfix/estimate/sighting_model.hpp"
#include "roomfix/estimate/tag_model.hpp"
#include "roomfix/estimate/tracker_settings.hpp"
#include "roomfix/site/site.hpp"

namespace roomfix {

struct TrackingModels {
    TrackingModels(const Site& site, const TrackerSettings& settings);

    /// Number of a source by its name; new names get a new number.
    int source(const std::string& name);
    const std::string& source_name(int source) const { return source_names[static_cast<std::size_t>(source)]; }

    /// Does anything but its looks tell the robot from others of its kind: wheels, a receiver, a tag, a camera of its own?
    bool has_mark(int robot) const;

    const RangeSource& receiver(int robot, int number = 0) const {
        const auto& all = receivers[static_cast<std::size_t>(robot)];
        return all[std::min(static_cast<std::size_t>(number), all.size() - 1)];
    }
    /// From now on the robot's senses err as was learned of them.
    void learn(int robot, const SenseNoise& noise);

    KnownLandmark landmark(int number) const {
        const auto k = static_cast<std::size_t>(number);
        return {number, &landmark_points[k], site.landmarks[k].sigma};
    }

    Site site;
    TrackerSettings settings;
    std::vector<MotionModel> motion;                  // of each robot
    std::vector<std::vector<RangeSource>> receivers;  // of each robot: at least one
    std::vector<DetectorSource> detectors;            // of each robot
    std::vector<OdometryNoise> wheels;                // of each robot
    std::vector<OdometryPrior> odometry;              // of each robot
    std::vector<OdometryTrack> driven;                // of each robot: what its wheels said
    std::vector<LandmarkShape> shapes;
    std::vector<std::vector<Eigen::Vector3d>> landmark_points;  // of each landmark, map
    std::vector<Mark> marks;                                    // landmarks as detectors see them
    std::vector<std::string> source_names;
    int range_source = 0;  // all ranges are one source
    int wheel_source = 0;
    int sighting_source = 0;
    std::map<int, View> views;             // by source: cameras in the room
    std::map<int, PoseSource> fixed;       // by source: cameras in the room, and whatever else gives poses
    std::map<int, OnboardSource> onboard;  // by source: cameras on robots
};

}  // namespace roomfix
