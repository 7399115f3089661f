// Where robots truly were, from a file.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "roomfix/base/result.hpp"
#include "roomfix/base/time.hpp"
#include "roomfix/geometry/pose.hpp"

namespace roomfix {

struct StampedPose {
    Nanoseconds time = 0;
    Pose2 pose;
    bool yaw_known = true;  // many a truth is a place only; yaw is 0 then
};
/// Of each robot, in the order of their times.
using Truth = std::map<std::string, std::vector<StampedPose>>;

/// "unknown", "unknown-1", "unknown-2", ... in the column robot: a person or another thing that is no robot of the site.
bool names_unknown_thing(std::string_view name);
/// The true robots, or the true unknown things, alone.
Truth robots_of(const Truth& truth);
Truth unknown_things_of(const Truth& truth);

/// CSV with the columns time,robot,x,y,yaw or time,robot,x,y; yaw may be empty in any line. An error names the first line that cannot be read, or
/// the unknown thing that is at two places at one time.
Result<Truth> parse_truth(std::string_view text);
Result<Truth> load_truth(const std::string& file);

struct TruePose : Pose2 {
    bool yaw_known = true;
};
/// The true pose between two recorded ones not farther apart than `gap` (s); nothing beyond them. Its yaw lies between the two nearest that have
/// one, if these are not farther apart than `gap` either.
std::optional<TruePose> pose_at(const std::vector<StampedPose>& poses, Nanoseconds time, double gap = 2);

/// Poses as lines "time x y z qx qy qz qw", which the tool evo reads (TUM format). A yaw that is not known is written as 0.
std::string tum_text(const std::vector<StampedPose>& poses);

}  // namespace roomfix
