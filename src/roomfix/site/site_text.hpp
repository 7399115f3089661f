// A site as the text of a site file.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "roomfix/site/site.hpp"

namespace roomfix {

/// YAML of format 1 that parse_site() reads back to the same site. Numbers are written in full.
std::string site_text(const Site& site);

/// Values of a camera's keys `mount`, `pose`, `intrinsics` and `distortion`, each on one line.
std::string mount_text(const Mount& mount, const CameraModel& model);
std::string pose_text(const KnownPose& known, const CameraModel& model);
std::string intrinsics_text(const CameraModel& model, const IntrinsicsMatrix& covariance);
/// A robot's odometry, receiver or receivers, and detector, as it has them: key and value, each on one line.
std::vector<std::pair<std::string, std::string>> senses_text(const SiteRobot& robot);
/// A robot's parts as their points, whatever they were written as.
std::string parts_text(const std::vector<ConvexPart>& parts);
std::string distortion_text(const CameraModel& model);
/// A wall or a zone's border: [[x, y], ...].
std::string points_text(const Polyline& points);

}  // namespace roomfix
