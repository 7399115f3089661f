// A recorded turn or drive, from frames and odometry to a mount.
#pragma once

#include <functional>
#include <string>

#include "roomfix/calibrate/mount.hpp"
#include "roomfix/site/site.hpp"

namespace roomfix {

/// Looks for landmarks in all frames of `source` (folder or video) and calibrates the camera's mount with them, and with the wheels of
/// `odometry` (CSV; empty: none) if they were recorded with the same clock. `progress` gets 0..1.
Result<MountCalibration> calibrate_mount_from(const Site& site, const SiteCamera& camera, const std::string& source, const std::string& odometry,
                                              MountSettings settings, const std::function<void(double)>& progress = {});

}  // namespace roomfix
