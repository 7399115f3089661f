// Every kind of camera behind one call.
#pragma once

#include <variant>

#include "roomfix/pipeline/camera/corner_camera.hpp"
#include "roomfix/pipeline/camera/fixed_camera.hpp"
#include "roomfix/pipeline/camera/landmark_camera.hpp"
#include "roomfix/pipeline/camera/tag_camera.hpp"

namespace roomfix {

/// Each has robot(), look(frame, hints), sighting(), drawing().
using CameraKind = std::variant<FixedCamera, LandmarkCamera, CornerCamera, TagCamera>;

/// By the camera's placement and by what the site has: fixed in the map, on a robot, or of known height. An error if what the site says about it does not
/// fit together.
Result<CameraKind> make_camera(const Site& site, const SiteCamera& camera);

/// Looks at a frame of the camera's size.
void look(CameraKind& camera, const PictureView& frame, const FrameHints& hints);
/// What the last frame showed.
Sighting sighting_of(const CameraKind& camera);
/// The same, to be drawn into that frame.
Drawing drawing_of(const CameraKind& camera);
/// The last frame as it was looked at, which is what drawing_of() belongs to: the picture of a fixed camera that was moved is turned back.
LumaView picture_of(const CameraKind& camera, LumaView frame);
/// Index of the robot that carries it; -1: none, or unknown.
int robot_of(const CameraKind& camera);

}  // namespace roomfix
