#include "roomfix/overhead/floor_grid.hpp"

#include <algorithm>
#include <cmath>

namespace roomfix {
namespace {

struct Rectangle {
    Eigen::Vector2d low = Eigen::Vector2d::Constant(1e9);
    Eigen::Vector2d high = Eigen::Vector2d::Constant(-1e9);
};

/// All floor that some camera sees, as a rectangle along the map's axes.
Rectangle floor_in_sight(std::span<const SeenBy> cameras, const Body& body, double farthest) {
    Rectangle floor;
    for (const SeenBy& camera : cameras) {
        const View& view = *camera.view;
        const auto pixels = spread_pixels(view.model);
        for (Eigen::Index i = 0; i < pixels.cols(); ++i) {
            for (const double height : {0.0, std::min(body.height, 0.9 * view.position().z())}) {
                const auto seen = pixel_to_plane(view, pixels.col(i), height);
                if (!seen || (seen->point - view.position().head<2>()).norm() > farthest * view.position().z()) continue;
                floor.low = floor.low.cwiseMin(seen->point);
                floor.high = floor.high.cwiseMax(seen->point);
            }
        }
    }
    return floor;
}

bool same(const View& a, const View& b) {
    return a.model.width == b.model.width && a.model.height == b.model.height && a.model.kind == b.model.kind && a.model.grid == b.model.grid &&
           a.model.intrinsics() == b.model.intrinsics() && a.map_from_camera.pose.matrix() == b.map_from_camera.pose.matrix();
}

}  // namespace

bool FloorGrid::fits(std::span<const SeenBy> cameras, const Body& body, const FloorGridSettings& settings) const {
    const bool same_body = body.radius == radius_ && body.height == body_height_ && settings.step == settings_.step && settings.most == settings_.most &&
                           settings.farthest == settings_.farthest;
    return same_body && std::equal(cameras.begin(), cameras.end(), pictures_.begin(), pictures_.end(), [](const SeenBy& camera, const Picture& picture) {
               return camera.evidence->width == picture.width && camera.evidence->height == picture.height && camera.evidence->scale == picture.scale &&
                      (camera.walls ? *camera.walls == picture.walls : picture.walls.empty()) && same(*camera.view, picture.view);
           });
}

void FloorGrid::lay(std::span<const SeenBy> cameras, const Body& body, const FloorGridSettings& settings) {
    settings_ = settings;
    radius_ = body.radius;
    body_height_ = body.height;
    pictures_.clear();
    patches_.clear();
    places_.clear();
    boxes_.clear();
    for (const SeenBy& camera : cameras) {
        const Evidence& evidence = *camera.evidence;
        pictures_.push_back({*camera.view, evidence.width, evidence.height, evidence.scale, camera.walls ? *camera.walls : std::vector<Polyline>()});
    }
    const Rectangle floor = floor_in_sight(cameras, body, settings.farthest);
    if (floor.low.x() > floor.high.x()) return;
    const Eigen::Vector2d extent = floor.high - floor.low;
    const double step = std::max(settings.step, std::sqrt(extent.x() * extent.y() / settings.most));
    for (double y = floor.low.y(); y <= floor.high.y(); y += patch_places * step) {
        for (double x = floor.low.x(); x <= floor.high.x(); x += patch_places * step) add_patch(cameras, body, {x, y}, floor.high, step);
    }
}

/// From its corner on, but not beyond `end`.
void FloorGrid::add_patch(std::span<const SeenBy> cameras, const Body& body, const Eigen::Vector2d& corner, const Eigen::Vector2d& end, double step) {
    Patch patch{corner + Eigen::Vector2d::Constant(0.5 * (patch_places - 1) * step), places_.size(), 0};
    for (int i = 0; i < patch_places * patch_places; ++i) {
        const Eigen::Vector2d place = corner + step * Eigen::Vector2d(i % patch_places, i / patch_places);
        if (place.x() > end.x() || place.y() > end.y()) continue;
        bool anything = false;
        const std::size_t before = boxes_.size();
        for (const SeenBy& camera : cameras) {
            boxes_.push_back(box_at(camera, body, place));
            anything |= !boxes_.back().empty();
        }
        if (anything) {
            places_.push_back(place);
        } else {
            boxes_.resize(before);
        }
    }
    patch.end = places_.size();
    if (patch.end > patch.begin) patches_.push_back(patch);
}

FloorGrid::Box FloorGrid::box_at(const SeenBy& camera, const Body& body, const Eigen::Vector2d& place) const {
    const View& view = *camera.view;
    const Evidence& evidence = *camera.evidence;
    const auto foot = project_map_point(view, {place.x(), place.y(), 0});
    const auto top = project_map_point(view, {place.x(), place.y(), body.height});
    if (!foot || !top || hidden_from(camera, body, place).whole) return {};
    const double distance = (view.position() - Eigen::Vector3d(place.x(), place.y(), 0.5 * body.height)).norm();
    const double reach = body.radius * view.model.fx / std::max(distance, 0.1);
    const auto cell = [&](double pixel, int size) {
        return static_cast<std::int16_t>(std::clamp(static_cast<int>(std::clamp(pixel, -1e6, 1e6) / evidence.scale), 0, size));
    };
    return {cell(std::min(foot->x(), top->x()) - reach, evidence.width), cell(std::min(foot->y(), top->y()) - reach, evidence.height),
            cell(std::max(foot->x(), top->x()) + reach + evidence.scale, evidence.width),
            cell(std::max(foot->y(), top->y()) + reach + evidence.scale, evidence.height)};
}

}  // namespace roomfix
