// What robots and cameras are called in ROS: topics and frames.
#pragma once

#include <map>
#include <set>
#include <string>

namespace roomfix {

/// Ids as words of ROS names: letters, digits and single underscores, not beginning with a digit. No two ids get the same word.
class RosNames {
public:
    /// The same word for the same id every time; the first of two that would be alike keeps its own: "cart-1" becomes "cart_1", or "cart_1_2".
    const std::string& of(const std::string& id);
    /// Its word is free again.
    void forget(const std::string& id);

private:
    std::map<std::string, std::string> words_;
    std::set<std::string> taken_;
};

/// A robot's frames (REP 105).
struct RobotFrames {
    std::string odom;  // where its odometry started
    std::string base;  // on the floor below its middle
};

/// A robot that is the only one has the frames that it has by itself, `odom` and `base_link`; of several, each has its own: `r1/odom`, `r1/base_link`.
RobotFrames robot_frames(const std::string& robot_word, bool only_one);

inline const std::string map_frame = "map";

/// Of the camera itself: x right, y down, z forward.
inline std::string camera_frame(const std::string& camera_word) { return camera_word + "_optical_frame"; }

}  // namespace roomfix
