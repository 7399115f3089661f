#include <fmt/format.h>

#include <cmath>
#include <memory>

#include "roomfix/base/number.hpp"
#include "roomfix/connect/overlay.hpp"
#include "roomfix/pipeline/single_shot.hpp"
#include "roomfix/pipeline/tag_camera.hpp"

namespace roomfix {
namespace {

/// A camera that sees tags; where a picture shows none, `corners` may tell its place.
class TagShot {
public:
    TagShot(const Site& site, const SiteCamera& camera, std::optional<Shot> corners) : camera_(camera), looking_(site, camera), corners_(std::move(corners)) {}

    std::vector<Fix> fixes(const std::string& image, const PictureView& frame) {
        looking_.look(frame.grey, result_);
        if (by_corners()) return corners_->fixes(image, frame);
        Fix fix = looking_.fix_of(result_, parse_integer(std::filesystem::path(image).stem().string()).value_or(0), {camera_.id});
        fix.image = image;
        return {fix};
    }
    Result<void> overlay(const std::filesystem::path& file, LumaView frame) const {
        if (by_corners()) return corners_->overlay(file, frame);
        CeilingOverlay drawn;
        for (const SeenTag& tag : result_.seen) {
            LandmarkObservation seen;
            for (const Eigen::Vector2d& corner : tag.corners) seen.points.push_back({corner, Eigen::Matrix2d::Identity()});
            drawn.landmarks.push_back(seen);
            const std::string name = looking_.name_of_tag(tag);
            drawn.names.push_back(name.empty() ? fmt::format("{} {}", name_of(tag.family), tag.number) : name);
        }
        drawn.caption = result_.located.reason;
        if (!result_.located.places.empty()) {
            const UncertainPose3& best = result_.located.places[0].map_from_camera;
            const Eigen::Vector3d& p = best.pose.translation();
            drawn.caption = fmt::format("camera at {:.3f}, {:.3f}, {:.3f} m, +- {:.1f} mm", p.x(), p.y(), p.z(),
                                        1e3 * std::sqrt(best.covariance.topLeftCorner<3, 3>().trace()));
        }
        return save_ceiling_overlay(file, frame, drawn, frame.width < 480 ? 2 : 1);
    }

private:
    bool by_corners() const { return corners_ && result_.located.places.empty(); }

    SiteCamera camera_;
    TagCamera looking_;
    std::optional<Shot> corners_;
    TagCameraResult result_;
};

}  // namespace

Result<Shot> prepare_tag_shot(const Site& site, const SiteCamera& camera, const ShotOptions& options) {
    for (const TagFamily family : site.tag_families()) {
        if (!can_read(family)) {
            return Error{fmt::format(
                "this roomfix was built without OpenCV's aruco module and cannot read {}: install libopencv-contrib-dev and build it again", name_of(family))};
        }
    }
    std::optional<Shot> corners;
    if (!site.corners.empty()) {
        auto prepared = prepare_corner_shot(site, camera, options);
        if (!prepared) return prepared.error();
        corners = std::move(*prepared);
    }
    const auto shot = std::make_shared<TagShot>(site, camera, std::move(corners));
    Shot prepared;
    prepared.model = camera.model;
    prepared.fixes = [shot](const std::string& image, const PictureView& frame) { return shot->fixes(image, frame); };
    prepared.overlay = [shot](const std::filesystem::path& file, LumaView frame) { return shot->overlay(file, frame); };
    return prepared;
}

}  // namespace roomfix
