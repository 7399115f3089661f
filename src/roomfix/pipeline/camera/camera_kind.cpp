#include "roomfix/pipeline/camera/camera_kind.hpp"

namespace roomfix {
namespace {

template <class Kind>
Result<CameraKind> made(const Site& site, const SiteCamera& camera) {
    auto kind = Kind::create(site, camera);
    if (!kind) return kind.error();
    return CameraKind(std::move(*kind));
}

}  // namespace

Result<CameraKind> make_camera(const Site& site, const SiteCamera& camera) {
    if (looks_for_tags(site, camera)) return made<TagCamera>(site, camera);
    if (looks_for_corners(site, camera)) return made<CornerCamera>(site, camera);
    if (std::holds_alternative<Mount>(camera.placement)) return made<LandmarkCamera>(site, camera);
    return made<FixedCamera>(site, camera);
}

void look(CameraKind& camera, const PictureView& frame, const FrameHints& hints) {
    std::visit([&](auto& kind) { kind.look(frame, hints); }, camera);
}

Sighting sighting_of(const CameraKind& camera) {
    return std::visit([](const auto& kind) { return kind.sighting(); }, camera);
}

Drawing drawing_of(const CameraKind& camera) {
    return std::visit([](const auto& kind) { return kind.drawing(); }, camera);
}

LumaView picture_of(const CameraKind& camera, LumaView frame) {
    const auto* fixed = std::get_if<FixedCamera>(&camera);
    return fixed && fixed->picture().data ? fixed->picture() : frame;
}

int robot_of(const CameraKind& camera) {
    return std::visit([](const auto& kind) { return kind.robot(); }, camera);
}

}  // namespace roomfix
