#include "roomfix/pipeline/camera_pipeline.hpp"

namespace roomfix {

Result<std::unique_ptr<CameraPipeline>> CameraPipeline::create(const Site& site, const SiteCamera& camera) {
    if (const auto* height = std::get_if<KnownHeight>(&camera.placement)) {
        const bool has_something_to_see = !site.corners.empty() || looks_for_tags(site, camera);
        if (!has_something_to_see || height->robot.empty()) return std::unique_ptr<CameraPipeline>();
    }
    auto kind = make_camera(site, camera);
    if (!kind) return kind.error();
    return std::unique_ptr<CameraPipeline>(new CameraPipeline(camera, std::move(*kind)));
}

double CameraPipeline::look(const PictureView& frame, Nanoseconds time, const FrameHints& hints) {
    const double frozen = frozen_.seconds(frame.grey, time);
    if (frozen > frozen_after) return frozen;
    roomfix::look(kind_, frame, hints);
    return 0;
}

}  // namespace roomfix
