// Messages in Foxglove's JSON schemas.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "roomfix/connect/foxglove_server.hpp"
#include "roomfix/observation/fix.hpp"
#include "roomfix/site/site.hpp"

namespace roomfix {

/// Channels of the schemas that are used here.
FoxgloveChannel pose_channel(const std::string& topic);       // foxglove.PoseInFrame
FoxgloveChannel scene_channel(const std::string& topic);      // foxglove.SceneUpdate
FoxgloveChannel transform_channel(const std::string& topic);  // foxglove.FrameTransform
FoxgloveChannel picture_channel(const std::string& topic);    // foxglove.CompressedImage

/// A robot's pose in the map; of unknown direction: along x.
std::string pose_message(const Fix& fix);
/// map -> ROBOT.
std::string transform_message(const Fix& fix);
/// Walls, zones and beacons; stays.
std::string map_scene(const Site& site);
/// Robots and unknown things with their names and 95 % ellipses; each goes by itself a second after it was last told.
std::string robots_scene(const Site& site, const std::vector<Fix>& fixes, Nanoseconds time);
/// A JPEG picture of a camera.
std::string picture_message(const std::string& camera, Nanoseconds time, const std::vector<std::uint8_t>& jpeg);

}  // namespace roomfix
