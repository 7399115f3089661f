// What was recorded: fixes and the truth, from files.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "roomfix/base/result.hpp"
#include "roomfix/observation/fix.hpp"

namespace roomfix {

/// Fixes of a JSON-lines file, as roomfix writes them. Bad lines cost themselves only and are in `problems`.
struct RecordedFixes {
    std::vector<Fix> fixes;  // in the order of their times
    std::vector<std::string> problems;
};
RecordedFixes parse_fixes(std::string_view text);
Result<RecordedFixes> load_fixes(const std::string& file);

struct StampedPose {
    Nanoseconds time = 0;
    Pose2 pose;
};
/// Of each robot, in the order of their times.
using Truth = std::map<std::string, std::vector<StampedPose>>;
/// CSV with the columns time,robot,x,y,yaw. An error names the first line that cannot be read.
Result<Truth> parse_truth(std::string_view text);
Result<Truth> load_truth(const std::string& file);

/// The true pose between two recorded ones not farther apart than `gap` (s); nothing beyond them.
std::optional<Pose2> pose_at(const std::vector<StampedPose>& poses, Nanoseconds time, double gap = 2);

/// Poses as lines "time x y z qx qy qz qw", which the tool evo reads (TUM format).
std::string tum_text(const std::vector<StampedPose>& poses);

}  // namespace roomfix
