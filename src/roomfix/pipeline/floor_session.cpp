#include "roomfix/pipeline/floor_session.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>

#include "roomfix/imaging/tag_detector.hpp"
#include "roomfix/pipeline/camera/corner_camera.hpp"

namespace roomfix {
namespace {

constexpr double on_floor = 0.005;  // m: a tag no higher lies on the floor
constexpr double lies_flat = 0.9998;

/// Four clicks on one tile.
Result<FloorSource> clicked_tile(const FloorOptions& options) {
    if (options.tile.size() != 4) return Error{fmt::format("a tile has four corners, {} were given", options.tile.size())};
    if (!(options.grid.size > 0)) return Error{"a tile needs a size: --tile-size-mm"};
    const Pose2& at = options.grid.map_from_grid;
    FloorSource clicks{"clicked tile", {}, {}, options.grid.size_sigma / options.grid.size, {at.x, at.y}};
    const std::array<Eigen::Vector2d, 4> corners = {Eigen::Vector2d(0, 0), {1, 0}, {1, 1}, {0, 1}};
    for (std::size_t i = 0; i < 4; ++i) {
        const Eigen::Vector2d map = Eigen::Vector2d(at.x, at.y) + Eigen::Rotation2Dd(at.yaw) * (options.grid.size * corners[i]);
        clicks.sightings.push_back(clicked_point(options.tile[i], map, options.click_sigma));
    }
    return clicks;
}

/// The site's tags on the floor that the picture shows.
void add_tags(const Site& site, LumaView picture, std::vector<FloorSource>& sources) {
    std::vector<const SiteLandmark*> flat;
    for (const SiteLandmark& landmark : site.landmarks) {
        const Eigen::Isometry3d& at = landmark.map_from_landmark;
        if (std::holds_alternative<Tag>(landmark.kind) && std::abs(at.translation().z()) < on_floor && at.linear()(2, 2) > lies_flat) flat.push_back(&landmark);
    }
    if (flat.empty()) return;
    TagDetector detector(site.tag_families());
    std::vector<SeenTag> seen;
    detector.detect(picture, seen);
    for (const SeenTag& tag : seen) {
        for (const SiteLandmark* landmark : flat) {
            if (!std::get<Tag>(landmark->kind).is(tag.family, tag.number)) continue;
            FloorSource source{"tag " + landmark->id};
            const auto corners = map_points(*landmark);
            source.place_sigma = landmark->sigma;
            const double sigma = detector.settings().corner_sigma;
            for (std::size_t i = 0; i < 4; ++i) source.sightings.push_back(clicked_point(tag.corners[i], corners[i].head<2>(), sigma));
            sources.push_back(std::move(source));
        }
    }
}

/// The whole pose that a corner gives to a camera of known height.
Result<FloorSource> corner_source(const Site& site, const SiteCamera& camera, LumaView picture, const FloorOptions& options) {
    if (!options.height) return Error{"a corner tells the camera's place only together with its height above the floor: add --height"};
    FrameHints hints;
    for (std::size_t i = 0; i < site.corners.size(); ++i) {
        if (site.corners[i].id == options.corner) hints.corner = static_cast<int>(i);
    }
    if (hints.corner < 0) return Error{fmt::format("--corner {}: the site has no such corner", options.corner)};
    SiteCamera at_height = camera;
    at_height.placement = KnownHeight{*options.height, options.height_sigma, ""};
    auto looking = CornerCamera::create(site, at_height);
    if (!looking) return looking.error();
    looking->look(picture, hints);
    const auto& places = looking->located().places;
    if (places.empty()) return Error{fmt::format("--corner {}: {}", options.corner, looking->reason())};
    if (places.size() > 1 && places[0].weight < likely) {
        return Error{fmt::format("--corner {}: the picture allows {} poses; add floor points, or state the corner's 'moulding' if it has one", options.corner,
                                 places.size())};
    }
    return FloorSource{"corner " + options.corner, {}, places[0].map_from_camera};
}

}  // namespace

Result<FloorSession> calibrate_floor_from(const Site& site, const SiteCamera& camera, LumaView picture, const FloorOptions& options) {
    if (picture.width != camera.model.width || picture.height != camera.model.height) {
        return Error{fmt::format("the picture is {} x {} pixels, camera {} has {} x {}", picture.width, picture.height, camera.id, camera.model.width,
                                 camera.model.height)};
    }
    FloorSession session;
    if (!options.points.empty()) {
        FloorSource clicks{fmt::format("{} points", options.points.size())};
        for (const FloorPoint& p : options.points) clicks.sightings.push_back(clicked_point(p.pixel, p.map, options.click_sigma));
        session.sources.push_back(std::move(clicks));
    }
    if (!options.tile.empty()) {
        auto clicks = clicked_tile(options);
        if (!clicks) return clicks.error();
        session.sources.push_back(std::move(*clicks));
    }
    add_tags(site, picture, session.sources);
    if (!options.corner.empty()) {
        auto corner = corner_source(site, camera, picture, options);
        if (!corner) return corner.error();
        session.sources.push_back(std::move(*corner));
    }
    auto found = calibrate_floor(camera.model, camera.intrinsics_covariance, session.sources);
    if (!found) return found.error();
    if (!options.tile.empty() && options.follow_joints) {
        UncertainPose3 start;
        FloorSource joints = find_tile_grid_from_either(picture, camera.model, *found, options.grid, session.sources, start);
        if (!joints.sightings.empty()) {
            session.sources.push_back(std::move(joints));
            found = calibrate_floor(camera.model, camera.intrinsics_covariance, session.sources, start);
            if (!found) return found.error();
        }
    }
    if (found->rival) {
        const Eigen::Vector3d a = found->map_from_camera.pose.translation(), b = found->rival->translation();
        return Error{
            fmt::format("the camera may be at ({:.2f}, {:.2f}, {:.2f}) m or at ({:.2f}, {:.2f}, {:.2f}) m: these points are too close together to tell; "
                        "add a point of the floor farther away",
                        a.x(), a.y(), a.z(), b.x(), b.y(), b.z())};
    }
    session.calibration = std::move(*found);
    return session;
}

}  // namespace roomfix
