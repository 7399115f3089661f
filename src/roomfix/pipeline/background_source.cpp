#include "roomfix/pipeline/background_source.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "roomfix/connect/frame_source.hpp"
#include "roomfix/imaging/picture_stabiliser.hpp"

namespace roomfix {

Result<LearnedBackground> learn_background(const SiteCamera& camera, const std::vector<std::string>& sources, const std::function<void(double)>& progress) {
    BackgroundLearner learner;
    ColourFrames colours;
    PictureStabiliser stabiliser(camera.model);
    for (std::size_t i = 0; i < sources.size(); ++i) {
        auto source = open_source(sources[i]);
        if (!source) return source.error();
        if ((*source)->live()) return Error{fmt::format("{}: a background is learned from a recording, not from a live camera", sources[i])};
        SourceFrame frame;
        for (double seen = 0;; ++seen) {
            const auto more = (*source)->next(frame);
            if (!more) return more.error();
            if (!*more) break;
            if (frame.image.width() != camera.model.width || frame.image.height() != camera.model.height) {
                return Error{fmt::format("{}: background frame {} is {} x {} pixels, camera {} has {} x {}: record it with the same settings", sources[i],
                                         frame.name, frame.image.width(), frame.image.height(), camera.id, camera.model.width, camera.model.height)};
            }
            if (!stabiliser.has_reference()) stabiliser.set_reference({frame.image, &frame.colour});
            const PictureView picture = stabiliser.steady({frame.image, &frame.colour});
            learner.add(picture.grey);
            if (picture.colour) colours.add(*picture.colour);
            if (progress && (*source)->count() > 0) {
                progress((static_cast<double>(i) + std::min(1.0, seen / static_cast<double>((*source)->count()))) / static_cast<double>(sources.size()));
            }
        }
    }
    if (learner.frames() == 0) return Error{fmt::format("camera {}: the background has no frame", camera.id)};
    LearnedBackground background{learner.learn(), {}};
    background.colour.learn(colours.frames());
    return background;
}

std::vector<std::string> background_sources(const Site& site, const SiteCamera& camera, const std::vector<std::string>& given) {
    if (!given.empty() || camera.background.empty()) return given;
    return {resolved_path(site, camera.background)};
}

std::optional<double> offset_from_background(const Site& site, const SiteCamera& camera, LumaView picture) {
    const std::vector<std::string> sources = background_sources(site, camera, {});
    if (sources.empty()) return std::nullopt;
    const auto background = learn_background(camera, sources);
    if (!background) return std::nullopt;
    PictureStabiliser stabiliser(camera.model);
    stabiliser.set_reference(background->grey.mean());
    (void)stabiliser.steady(picture);
    return stabiliser.moved() ? std::optional(stabiliser.offset()) : std::nullopt;
}

Result<void> learn_backgrounds(SiteTracker& tracker, const std::vector<std::string>& for_all, const BackgroundListener& listener) {
    for (std::size_t i = 0; i < tracker.cameras(); ++i) {
        const SiteCamera& camera = tracker.camera(i);
        if (!tracker.is_fixed(i)) continue;
        const std::vector<std::string> sources = background_sources(tracker.site(), camera, for_all);
        if (sources.empty()) {
            if (listener.none) listener.none(camera);
            continue;
        }
        auto background = learn_background(camera, sources, listener.progress ? listener.progress(camera) : nullptr);
        if (!background) return background.error();
        tracker.set_background(i, std::move(background->grey), std::move(background->colour));
    }
    return {};
}

}  // namespace roomfix
