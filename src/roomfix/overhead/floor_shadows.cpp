#include "roomfix/overhead/floor_shadows.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace roomfix {
namespace {

constexpr int cell = Evidence::cell;
constexpr float least_doubtful = 1.2f;  // pixels of a cell that may as well be a shadow, for a look at the other cameras
constexpr float plainly_floor = 0.95f;  // part of the pixels there that show the background
constexpr int reach = 1;                // px around the place in the other camera: calibrations are not exact

/// Does no wall stand between the camera and a place on the floor?
bool in_sight(const SeenBy& camera, const Eigen::Vector2d& place) {
    return !camera.walls || !wall_cover(*camera.view, *camera.walls, place, 0, 0, camera.evidence->scale).whole;
}

float doubtful_in(const Evidence& evidence, int left, int top) {
    float sum = 0;
    if (left + cell <= evidence.width && top + cell <= evidence.height) {
        const float* row = evidence.perhaps.data() + static_cast<std::ptrdiff_t>(top) * evidence.width + left;
        std::array<float, cell> columns{};
        for (int y = 0; y < cell; ++y, row += evidence.width) {
            for (std::size_t x = 0; x < cell; ++x) columns[x] += row[x];
        }
        for (const float column : columns) sum += column;
        return sum / evidence.perhaps_part;
    }
    for (int y = top; y < std::min(top + cell, evidence.height); ++y) {
        for (int x = left; x < std::min(left + cell, evidence.width); ++x) sum += evidence.perhaps[static_cast<std::size_t>(y * evidence.width + x)];
    }
    return sum / evidence.perhaps_part;
}

/// Does a camera see a place on the floor, and nothing but the floor there?
bool sees_floor(const SeenBy& camera, const Eigen::Vector2d& place) {
    if (!in_sight(camera, place)) return false;
    const auto pixel = project_map_point(*camera.view, {place.x(), place.y(), 0});
    if (!pixel) return false;
    const Evidence& evidence = *camera.evidence;
    const int x = static_cast<int>(std::floor((pixel->x() + 0.5) / evidence.scale));
    const int y = static_cast<int>(std::floor((pixel->y() + 0.5) / evidence.scale));
    if (x < reach || y < reach || x + reach >= evidence.width || y + reach >= evidence.height) return false;
    const Evidence::Sums around = evidence.box(x - reach, y - reach, x + reach + 1, y + reach + 1);
    const int columns = Evidence::cells(x + reach + 1) - (x - reach) / cell;
    const int rows = Evidence::cells(y + reach + 1) - (y - reach) / cell;
    return around.plain > plainly_floor * static_cast<float>(columns * rows * cell * cell);
}

void rule_out_shadow(Evidence& evidence, int left, int top) {
    for (int y = top; y < std::min(top + cell, evidence.height); ++y) {
        for (int x = left; x < std::min(left + cell, evidence.width); ++x) evidence.rule_out_shadow(static_cast<std::size_t>(y * evidence.width + x));
    }
}

}  // namespace

void rule_out_shadows(std::span<const SeenBy> cameras, std::span<Evidence> evidence) {
    for (std::size_t c = 0; c < cameras.size(); ++c) {
        Evidence& own = evidence[c];
        for (int top = 0; top < own.height; top += cell) {
            for (int left = 0; left < own.width; left += cell) {
                if (doubtful_in(own, left, top) < least_doubtful) continue;
                const Eigen::Vector2d pixel((left + 0.5 * cell) * own.scale - 0.5, (top + 0.5 * cell) * own.scale - 0.5);
                const auto floor = pixel_to_plane(*cameras[c].view, pixel, 0);
                if (!floor || !in_sight(cameras[c], floor->point)) continue;
                for (std::size_t other = 0; other < cameras.size(); ++other) {
                    if (other == c || !sees_floor(cameras[other], floor->point)) continue;
                    rule_out_shadow(own, left, top);
                    break;
                }
            }
        }
    }
}

}  // namespace roomfix
