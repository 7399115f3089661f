#include "roomfix/overhead/robot_search.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "roomfix/overhead/keep_apart.hpp"

namespace roomfix {
namespace {

// What a pixel says about a silhouette, in pixels of plain foreground inside it.
constexpr double shadow_inside = 0.4;    // may be a dark robot
constexpr double bare_inside = 0.45;     // should be foreground; less than 1: it may be hidden by something
constexpr double certain_outside = 0.8;  // should be inside
constexpr double shadow_outside = 0.05;

constexpr int rows_looked_at = 14;  // of a silhouette: enough for a coarse pose

int row_step(const Silhouette& silhouette) {
    const PixelBox box = box_around(silhouette.polygon());
    return std::max(1, static_cast<int>((box.high.y() - box.low.y()) / rows_looked_at));
}

}  // namespace

Blob measure_blob(const ForegroundMasks& masks, const Component& component) {
    Blob blob{component};
    const int step = std::max(1, (component.bottom - component.top) / (2 * rows_looked_at));
    int foreground = 0;
    int shadow = 0;
    int rows = 0;
    for (int y = component.top; y <= component.bottom; y += step, ++rows) {
        foreground += masks.foreground->count_run(y, component.left, component.right + 1);
        shadow += masks.shadow->count_run(y, component.left, component.right + 1);
    }
    const double scale = static_cast<double>(component.bottom - component.top + 1) / rows;
    blob.shadow = std::min(shadow, foreground) * scale;
    blob.certain = foreground * scale - blob.shadow;
    return blob;
}

CoarsePose coarse_agreement(const ForegroundMasks& masks, const View& view, const ShapePoints& shape, const Pose2& pose, const Blob& blob) {
    CoarsePose result;
    result.pose = pose;
    result.silhouette = project_silhouette(view, shape, pose);
    if (!result.silhouette.valid()) return result;
    result.inside = count_region(*masks.foreground, *masks.shadow, masks.taken, result.silhouette.polygon(), row_step(result.silhouette));
    const RegionCount& in = result.inside;
    if (in.area < 1) return result;
    const double shadow = std::min(in.shadow, in.foreground);
    const double certain = in.foreground - shadow;
    result.missing = std::max(blob.certain - certain, 0.0);
    result.agreement = certain + shadow_inside * shadow - bare_inside * std::max(in.area - in.taken - in.foreground, 0.0) - certain_outside * result.missing -
                       shadow_outside * std::max(blob.shadow - shadow, 0.0);
    return result;
}

std::optional<Pose2> place_from_centroid(const View& view, const ShapePoints& shape, const Eigen::Vector2d& centroid) {
    const auto first = pixel_to_plane(view, centroid, shape.height / 2);
    if (!first) return std::nullopt;
    Pose2 pose{first->point.x(), first->point.y(), 0};
    // The body's middle is not its silhouette's: shift by the difference once.
    const Silhouette silhouette = project_silhouette(view, shape, pose);
    if (!silhouette.valid()) return pose;
    const Eigen::Vector2d shift = first->by_pixel * (centroid - polygon_centroid(silhouette.polygon()));
    if (shift.norm() > 2 * shape.radius) return pose;
    return Pose2{pose.x + shift.x(), pose.y + shift.y(), 0};
}

CoarsePose climb(const ForegroundMasks& masks, const View& view, const ShapePoints& shape, CoarsePose start, const Blob& blob, double first_step) {
    CoarsePose best = std::move(start);
    const double smallest = first_step / 4;  // the outline's fit does the rest
    const auto try_pose = [&](const Pose2& pose) {
        const CoarsePose next = coarse_agreement(masks, view, shape, pose, blob);
        if (next.agreement <= best.agreement) return false;
        best = next;
        return true;
    };
    for (double step = first_step; step >= smallest; step /= 2) {
        const double turn = shape.round() ? 0 : step / shape.radius;
        for (int i = 0; i < 4; ++i) {
            bool better = false;
            const Pose2 p = best.pose;
            better |= try_pose({p.x + step, p.y, p.yaw}) || try_pose({p.x - step, p.y, p.yaw});
            const Pose2 q = best.pose;
            better |= try_pose({q.x, q.y + step, q.yaw}) || try_pose({q.x, q.y - step, q.yaw});
            const Pose2 r = best.pose;
            if (turn > 0) better |= try_pose({r.x, r.y, r.yaw + turn}) || try_pose({r.x, r.y, r.yaw - turn});
            if (!better) break;
        }
    }
    return best;
}

FloorRectangle floor_under(const View& view, const ShapePoints& shape, const Blob& blob) {
    // The blob's box's corners and middles, seen at floor level and at the robot's top.
    FloorRectangle floor{Eigen::Vector2d::Constant(1e9), Eigen::Vector2d::Constant(-1e9)};
    for (int i = 0; i < 9; ++i) {
        const double u = blob.component.left + 0.5 * (i % 3) * (blob.component.right - blob.component.left);
        const double v = blob.component.top + 0.5 * (i / 3) * (blob.component.bottom - blob.component.top);
        for (const double z : {0.0, shape.height}) {
            const auto p = pixel_to_plane(view, {u, v}, z);
            if (!p) continue;
            floor.low = floor.low.cwiseMin(p->point);
            floor.high = floor.high.cwiseMax(p->point);
        }
    }
    if (floor.empty()) return floor;
    const Eigen::Vector2d middle = 0.5 * (floor.low + floor.high);
    const Eigen::Vector2d extent = (0.5 * (floor.high - floor.low)).cwiseMin(12 * shape.radius);
    return {middle - extent, middle + extent};
}

void search_floor(const ForegroundMasks& masks, const View& view, const ShapePoints& shape, const Blob& blob, std::size_t most,
                  std::vector<CoarsePose>& found) {
    found.clear();
    const FloorRectangle floor = floor_under(view, shape, blob);
    if (floor.empty()) return;
    const double step = 0.4 * shape.radius;
    const int turns = shape.round() ? 1 : (shape.symmetry < 2 ? 4 : 6);
    for (double y = floor.low.y(); y <= floor.high.y(); y += step) {
        for (double x = floor.low.x(); x <= floor.high.x(); x += step) {
            CoarsePose best;
            for (int turn = 0; turn < turns; ++turn) {
                const CoarsePose next = coarse_agreement(masks, view, shape, {x, y, shape.symmetry * turn / turns}, blob);
                if (next.agreement > best.agreement && next.filled() > 0.3) best = next;
            }
            if (best.agreement > -1e8) found.push_back(best);
        }
    }
    std::sort(found.begin(), found.end(), [](const CoarsePose& a, const CoarsePose& b) { return a.agreement > b.agreement; });
    keep_apart(found, most,
               [&](const CoarsePose& a, const CoarsePose& b) { return std::hypot(a.pose.x - b.pose.x, a.pose.y - b.pose.y) < 0.5 * shape.radius; });
}

}  // namespace roomfix
