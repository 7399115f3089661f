// One camera at work: its frames in, what it saw of robots out.
#pragma once

#include <memory>
#include <string>

#include "roomfix/pipeline/camera/camera_kind.hpp"
#include "roomfix/pipeline/frozen_picture.hpp"

namespace roomfix {

/// A frame as it is shown, with what was seen in it.
struct ShownFrame {
    LumaImage picture;
    Drawing drawing;
    Nanoseconds time = 0;
};

class CameraPipeline {
public:
    /// Null for a camera that finds no robot. An error if what the site says about it does not fit together.
    static Result<std::unique_ptr<CameraPipeline>> create(const Site& site, const SiteCamera& camera);

    const SiteCamera& camera() const { return camera_; }
    const std::string& id() const { return camera_.id; }
    /// The camera as one that is fixed in the map; null if it is none.
    FixedCamera* fixed() { return std::get_if<FixedCamera>(&kind_); }
    const FixedCamera* fixed() const { return std::get_if<FixedCamera>(&kind_); }
    /// The robot that carries it; -1: none, or unknown.
    int robot() const { return robot_of(kind_); }

    /// Looks at a frame of the right size. Returns the seconds for which this very picture has been coming if it is frozen, 0 otherwise;
    /// what a frozen picture shows is not looked at.
    double look(const PictureView& frame, Nanoseconds time, const FrameHints& hints);
    /// What the last frame showed.
    Sighting sighting() const { return sighting_of(kind_); }
    /// The last frame and what was seen in it.
    ShownFrame shown(LumaView frame) const { return {copy_of(picture_of(kind_, frame)), drawing_of(kind_)}; }

private:
    CameraPipeline(const SiteCamera& camera, CameraKind kind) : camera_(camera), kind_(std::move(kind)) {}

    SiteCamera camera_;
    CameraKind kind_;
    FrozenPicture frozen_;
};

}  // namespace roomfix
