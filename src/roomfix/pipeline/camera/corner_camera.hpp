// A camera that looks for a room's corner: on a robot, or standing at a known height.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "roomfix/base/result.hpp"
#include "roomfix/connect/drawing.hpp"
#include "roomfix/corner/corner_locator.hpp"
#include "roomfix/corner/corner_observer.hpp"
#include "roomfix/imaging/colour_image.hpp"
#include "roomfix/pipeline/camera/sighting.hpp"

namespace roomfix {

/// A camera of known height does. One on a robot looks for landmarks if the site has some and it looks up to them, within 37 deg of
/// straight up; otherwise for corners, if the site has some.
bool looks_for_corners(const Site& site, const SiteCamera& camera);

class CornerCamera {
public:
    /// An error if the camera is neither on a robot nor of known height, or the site has no corners.
    static Result<CornerCamera> create(const Site& site, const SiteCamera& camera);

    /// Index of the robot that carries it, -1: none.
    int robot() const { return locator_.robot(); }
    void look(const PictureView& frame, const FrameHints& hints);
    /// The same for corners that somebody else saw in a frame.
    void place(CornerResult seen, const FrameHints& hints);
    Sighting sighting() const;
    Drawing drawing() const;
    /// Why the last frame showed no place; empty if it did.
    const std::string& reason() const { return located_.reason; }

    /// All places that the last frame allows.
    const LocatedCamera& located() const { return located_; }

private:
    CornerCamera(const Site& site, const SiteCamera& camera, const CornerLocator& locator);
    CameraHints hints_for(const FrameHints& hints) const;
    void locate(const CameraHints& hints);
    double late(const CameraPlace& place) const;

    Site site_;
    bool on_robot_;
    double readout_;  // s
    int rows_;        // of its pictures
    CornerLocator locator_;
    CornerObserver observer_;
    // Of the last frame:
    CornerResult seen_;
    LocatedCamera located_;
};

}  // namespace roomfix
