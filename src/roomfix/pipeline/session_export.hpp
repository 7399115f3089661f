// A session as a recording of ROS 2 messages: one MCAP file, or the folder that rosbag2 plays.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "roomfix/connect/rosbag2.hpp"
#include "roomfix/observation/fix.hpp"
#include "roomfix/site/site.hpp"

namespace roomfix {

/// Where a robot truly was.
struct TruePlace {
    Nanoseconds time = 0;
    std::string robot;
    Pose2 pose;
    bool yaw_known = true;
};

/// What a session holds beside the sources that its site names.
struct SessionRecords {
    std::filesystem::path site_file;
    std::vector<Fix> fixes;  // of robots
    std::vector<TruePlace> truth;
};

struct ExportReport {
    BagContents contents;
    std::vector<std::string> notes;  // what was left out and why, as sentences
};

/// Topics, and what they come from: `/ROBOT/pose` (fixes), `/ROBOT/odom` (odometry), `/ROBOT/truth`, `/CAMERA/image/compressed` and
/// `/CAMERA/camera_info` (image folders), `/tf` (see docs/formats.md). Everything in the order of its times. An error says what cannot be read or
/// written; what was written so far is removed.
Result<ExportReport> export_mcap(const Site& site, const SessionRecords& records, const std::filesystem::path& file,
                                 const std::function<void(double)>& progress = {});

/// The same in a new folder with its metadata.yaml. An error if there is something of that name.
Result<ExportReport> export_bag(const Site& site, const SessionRecords& records, const std::filesystem::path& folder,
                                const std::function<void(double)>& progress = {});

}  // namespace roomfix
