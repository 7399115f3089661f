#include <fmt/format.h>

#include <cmath>
#include <memory>

#include "roomfix/base/number.hpp"
#include "roomfix/connect/overlay.hpp"
#include "roomfix/connect/range_source.hpp"
#include "roomfix/corner/chou1986.hpp"
#include "roomfix/pipeline/corner_camera.hpp"
#include "roomfix/pipeline/single_shot.hpp"

namespace roomfix {
namespace {

/// A camera that sees corners, and what else is known about it.
class CornerShot {
public:
    CornerShot(const SiteCamera& camera, std::unique_ptr<CornerCamera> looking) : camera_(camera), looking_(std::move(looking)) {}

    Result<void> use(const Site& site, const ShotOptions& options) {
        for (std::size_t i = 0; i < site.corners.size(); ++i) {
            if (site.corners[i].id == options.corner) hints_.corner = static_cast<int>(i);
        }
        if (!options.corner.empty() && hints_.corner < 0) return Error{fmt::format("--corner {}: the site has no such corner", options.corner)};
        if (options.heading) hints_.heading = CameraHints::Heading{*options.heading, radians(15)};
        if (options.published) published_.emplace(camera_.model);
        if (options.ranges.empty()) return {};
        if (looking_->robot() < 0) return Error{fmt::format("--ranges: camera {} is on no robot: ranges are heard by a robot's receiver", camera_.id)};
        auto batch = load_ranges(options.ranges, site, looking_->robot());
        if (!batch) return batch.error();
        for (const std::string& problem : batch->problems) options.note(problem);
        ranges_ = std::move(batch->ranges);
        return {};
    }

    std::vector<Fix> fixes(const std::string& image, LumaView frame) {
        const auto stamp = parse_integer(std::filesystem::path(image).stem().string());
        const auto near = ranges_around(ranges_, looking_->robot(), stamp);
        hints_.ranges = near;
        if (published_) {
            look_as_published(frame);
        } else {
            looking_->look(frame, hints_, result_);
        }
        hints_.ranges = {};
        std::vector<std::string> sources = {camera_.id};
        if (!near.empty()) sources.emplace_back("ranges");
        Fix fix = looking_->fix_of(result_, stamp.value_or(0), sources);
        fix.image = image;
        return {fix};
    }

    Result<void> overlay(const std::filesystem::path& file, LumaView frame) const {
        CornerOverlay drawn;
        drawn.rejected = result_.seen.rejected;
        drawn.caption = result_.located.reason;
        if (!result_.located.places.empty()) {
            const CameraPlace& best = result_.located.places[0];
            drawn.corner = result_.seen.corners[static_cast<std::size_t>(best.observation)];
            drawn.name = looking_->corner_name(result_);
            const Eigen::Vector3d& p = best.map_from_camera.pose.translation();
            drawn.caption = fmt::format("camera at {:.3f}, {:.3f}, {:.3f} m, looks to {:.2f} deg, +- {:.1f} mm", p.x(), p.y(), p.z(), degrees(best.pose.yaw),
                                        1e3 * std::sqrt(best.covariance(0, 0) + best.covariance(1, 1)));
        }
        return save_corner_overlay(file, frame, drawn, frame.width < 480 ? 2 : 1);
    }

private:
    /// The paper states no uncertainty; its own experiment is off by up to 5 % of the distance.
    void look_as_published(LumaView frame) {
        result_.seen = {};
        const auto view = published_->locate(frame, &result_.seen.reason);
        if (view) {
            CornerObservation seen;
            seen.view = *view;
            seen.covariance = (Vector5d() << 4e-4, 4e-4, 4e-4, 1e-3, 1e-3).finished().asDiagonal();
            result_.seen.corners = {seen};
        }
        looking_->locator().locate(result_.seen.corners, hints_, result_.located);
        if (result_.located.places.empty() && result_.located.reason.empty()) result_.located.reason = result_.seen.reason;
    }

    SiteCamera camera_;
    std::unique_ptr<CornerCamera> looking_;
    CameraHints hints_;
    std::vector<RangeObservation> ranges_;
    std::optional<Chou1986> published_;
    CornerCameraResult result_;
};

}  // namespace

Result<Shot> prepare_corner_shot(const Site& site, const SiteCamera& camera, const ShotOptions& options) {
    auto looking = CornerCamera::for_camera(site, camera);
    if (!looking) return looking.error();
    const auto shot = std::make_shared<CornerShot>(camera, std::move(*looking));
    if (auto used = shot->use(site, options); !used) return used.error();
    Shot prepared;
    prepared.model = camera.model;
    prepared.fixes = [shot](const std::string& image, const PictureView& frame) { return shot->fixes(image, frame.grey); };
    prepared.overlay = [shot](const std::filesystem::path& file, LumaView frame) { return shot->overlay(file, frame); };
    return prepared;
}

}  // namespace roomfix
