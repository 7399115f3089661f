// A camera that sees corners, at work: from a frame to the camera's place, or to all that it may be.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "roomfix/base/result.hpp"
#include "roomfix/corner/corner_locator.hpp"
#include "roomfix/corner/corner_observer.hpp"
#include "roomfix/observation/fix.hpp"
#include "roomfix/observation/pose_observation.hpp"

namespace roomfix {

/// A camera of known height does. One on a robot looks for landmarks if the site has some and it looks up to them, within 37 deg of
/// straight up; otherwise for corners, if the site has some.
bool looks_for_corners(const Site& site, const SiteCamera& camera);

/// What one frame shows, for the fix and for drawing.
struct CornerCameraResult {
    CornerResult seen;
    LocatedCamera located;
};

class CornerCamera {
public:
    /// An error if the camera does not look for corners, or the site has none.
    static Result<std::unique_ptr<CornerCamera>> for_camera(const Site& site, const SiteCamera& camera);

    const CornerLocator& locator() const { return locator_; }
    /// Index of the robot that carries the camera, -1: none.
    int robot() const { return locator_.robot(); }
    void look(LumaView frame, const CameraHints& hints, CornerCameraResult& result);

    /// The corner that the best place rests on; empty if there is none.
    std::string corner_name(const CornerCameraResult& result) const;
    /// The result as a fix, with all places as hypotheses where there are several.
    Fix fix_of(const CornerCameraResult& result, Nanoseconds time, const std::vector<std::string>& sources) const;

private:
    static CornerSettings settings_for(const SiteCamera& camera);

    CornerCamera(const Site& site, const SiteCamera& camera, const CornerLocator& locator)
        : site_(site), locator_(locator), observer_(camera.model, locator.wall_angles(), settings_for(camera)) {}

    Site site_;
    CornerLocator locator_;
    CornerObserver observer_;
};

}  // namespace roomfix
