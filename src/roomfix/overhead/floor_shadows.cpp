#include "roomfix/overhead/floor_shadows.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace roomfix {
namespace {

constexpr int cell = Evidence::cell;
constexpr int least_doubtful = 6 * Evidence::certain / 5;  // parts of Evidence::certain, sum over a cell: for a look at the other cameras
constexpr int reach = 1;                                   // px around the place in the other camera: calibrations are not exact

/// Pixels of the small picture.
struct Square {
    int left = 0, top = 0, right = 0, bottom = 0;

    template <class Visit>
    void for_each(int width, Visit&& visit) const {
        for (int y = top; y < bottom; ++y) {
            for (int x = left; x < right; ++x) visit(static_cast<std::size_t>(y * width + x));
        }
    }
};

int doubtful_in(const Evidence& evidence, const Square& square) {
    int sum = 0;
    square.for_each(evidence.width, [&](std::size_t pixel) { sum += evidence.perhaps[pixel]; });
    return sum;
}

/// Log, mean over a square.
float light_in(const Evidence& evidence, const Square& square) {
    int sum = 0;
    square.for_each(evidence.width, [&](std::size_t pixel) { sum += evidence.light[pixel]; });
    return static_cast<float>(sum) / static_cast<float>(100 * (square.right - square.left) * (square.bottom - square.top));
}

/// Does no wall stand between the camera and a place on the floor?
bool in_sight(const SeenBy& camera, const Eigen::Vector2d& place) {
    return !camera.walls || !wall_cover(*camera.view, *camera.walls, place, 0, 0, camera.evidence->scale).whole;
}

enum class Shows { nothing, floor, shadow };

/// What does a camera show of a place on the floor that another one sees in some light?
Shows look_at(const SeenBy& camera, const Eigen::Vector2d& place, float light, const FloorShadowSettings& settings) {
    if (!in_sight(camera, place)) return Shows::nothing;
    const auto pixel = project_map_point(*camera.view, {place.x(), place.y(), 0});
    if (!pixel) return Shows::nothing;
    const Evidence& evidence = *camera.evidence;
    const int x = static_cast<int>(std::floor((pixel->x() + 0.5) / evidence.scale));
    const int y = static_cast<int>(std::floor((pixel->y() + 0.5) / evidence.scale));
    if (x < reach || y < reach || x + reach >= evidence.width || y + reach >= evidence.height) return Shows::nothing;
    const Square around{x - reach, y - reach, x + reach + 1, y + reach + 1};
    const int columns = Evidence::cells(around.right) - around.left / cell;
    const int rows = Evidence::cells(around.bottom) - around.top / cell;
    const Evidence::Sums seen = evidence.box(around.left, around.top, around.right, around.bottom);
    if (seen.plain > settings.plainly_floor * static_cast<float>(columns * rows * cell * cell)) return Shows::floor;
    return std::abs(light_in(evidence, around) - light) < settings.same_light ? Shows::shadow : Shows::nothing;
}

/// What the cameras together make of a cell in the picture of one of them. Nothing: it shows no shadow.
std::optional<float> part_that_counts(std::span<const SeenBy> cameras, std::size_t own, const Square& square, const FloorShadowSettings& settings) {
    const SeenBy& camera = cameras[own];
    const Eigen::Vector2d pixel = camera.evidence->scale * Eigen::Vector2d(square.left + 0.5 * cell, square.top + 0.5 * cell) - Eigen::Vector2d(0.5, 0.5);
    const auto floor = pixel_to_plane(*camera.view, pixel, 0);
    if (!floor || !in_sight(camera, floor->point)) return settings.on_wall;
    const float light = light_in(*camera.evidence, square);
    float part = settings.hidden_floor;
    for (std::size_t c = 0; c < cameras.size(); ++c) {
        const Shows shown = c == own ? Shows::nothing : look_at(cameras[c], floor->point, light, settings);
        if (shown == Shows::floor) return std::nullopt;
        if (shown == Shows::shadow) part = settings.agreed;
    }
    return part;
}

}  // namespace

void weigh_shadows(std::span<const SeenBy> cameras, std::span<Evidence> evidence, const FloorShadowSettings& settings) {
    for (std::size_t c = 0; c < cameras.size(); ++c) {
        Evidence& own = evidence[c];
        for (int top = 0; top < own.height; top += cell) {
            for (int left = 0; left < own.width; left += cell) {
                const Square square{left, top, std::min(left + cell, own.width), std::min(top + cell, own.height)};
                const int doubtful = doubtful_in(own, square);
                if (doubtful == 0) continue;
                const auto part = doubtful < least_doubtful ? std::optional(settings.little) : part_that_counts(cameras, c, square, settings);
                square.for_each(own.width, [&](std::size_t i) {
                    if (part) {
                        own.weigh_shadow(i, *part);
                    } else {
                        own.rule_out_shadow(i);
                    }
                });
            }
        }
        own.shadows_are_weighed();
    }
}

}  // namespace roomfix
