#include "roomfix/overhead/near_outlines.hpp"

#include <algorithm>
#include <cmath>

#include "roomfix/geometry/convex_hull.hpp"
#include "roomfix/overhead/wall_cover.hpp"

namespace roomfix {
namespace {

constexpr double most_move = 1.5;    // of the body's radius, of its corners by way and turn: farther away the lens is another
constexpr double least_depth = 0.1;  // m before the camera

}  // namespace

void NearOutlines::prepare(const View& view, const std::vector<ConvexPart>& parts, const Pose2& pose, int scale, double radius) {
    pose_ = pose;
    radius_ = radius;
    valid_ = false;
    corners_.clear();
    ends_.clear();
    const Eigen::Matrix3d camera_from_map = view.map_from_camera.pose.linear().transpose();
    camera_from_floor_ = camera_from_map.leftCols<2>();
    const double c = std::cos(pose.yaw);
    const double s = std::sin(pose.yaw);
    for (const ConvexPart& part : parts) {
        for (const Eigen::Vector3d& p : part.points) {
            Corner corner;
            corner.place = p.head<2>();
            corner.offset = camera_from_map * (Eigen::Vector3d(0, 0, p.z()) - view.position());
            const Eigen::Vector3d seen = corner.offset + camera_from_floor_ * Eigen::Vector2d(pose.x + c * p.x() - s * p.y(), pose.y + s * p.x() + c * p.y());
            if (!(seen.z() > least_depth)) return;
            corner.ray = seen.hnormalized();
            ProjectionJacobian jacobian;
            const auto pixel = project(view.model, corner.ray.homogeneous(), &jacobian);
            if (!pixel) return;
            corner.pixel = (*pixel - Eigen::Vector2d::Constant(0.5 * (scale - 1))) / scale;
            corner.by_ray = jacobian.leftCols<2>() / scale;
            corners_.push_back(corner);
        }
        // From left to right, so that they nearly are at poses near this one, too.
        std::sort(corners_.end() - static_cast<std::ptrdiff_t>(part.points.size()), corners_.end(),
                  [](const Corner& a, const Corner& b) { return a.pixel.x() < b.pixel.x(); });
        ends_.push_back(corners_.size());
    }
    valid_ = true;
}

bool NearOutlines::reach(const Pose2& pose) const {
    const double by_turn = 2 * radius_ * std::abs(std::sin(0.5 * (pose.yaw - pose_.yaw)));
    return valid_ && std::hypot(pose.x - pose_.x, pose.y - pose_.y) + by_turn < most_move * radius_;
}

void NearOutlines::cover(const Pose2& pose, int width, int height, int row_step, BodyMask& mask) const {
    mask.begin(width, height, row_step);
    const Eigen::Matrix<double, 3, 2> camera_from_robot = camera_from_floor_ * Eigen::Rotation2Dd(pose.yaw).toRotationMatrix();
    const Eigen::Vector3d middle = camera_from_floor_ * Eigen::Vector2d(pose.x, pose.y);
    std::vector<Eigen::Vector2d>& pixels = mask.pixels;
    std::size_t begin = 0;
    for (const std::size_t end : ends_) {
        const std::size_t count = end - begin;
        pixels.resize(2 * count + 1);
        for (std::size_t i = 0; i < count; ++i) {
            const Corner& corner = corners_[begin + i];
            const Eigen::Vector3d seen = corner.offset + middle + camera_from_robot * corner.place;
            if (!(seen.z() > least_depth)) return;
            pixels[i] = corner.pixel + corner.by_ray * (seen.hnormalized() - corner.ray);
        }
        begin = end;
        sort_nearly_sorted({pixels.data(), count});
        const int corners = convex_hull_of_sorted({pixels.data(), count}, {pixels.data() + count, count + 1});
        if (corners > 2) mask.add({pixels.data() + count, static_cast<std::size_t>(corners)});
    }
    mask.finish();
}

std::optional<double> upright_rows(const View& view, const Body& body, const Pose2& pose, int scale) {
    const auto top = project_map_point(view, {pose.x, pose.y, body.height});
    const auto foot = project_map_point(view, {pose.x, pose.y, 0});
    return top && foot ? std::optional(std::abs(foot->y() - top->y()) / scale) : std::nullopt;
}

void NearBody::prepare(const View& view, const std::vector<Polyline>* walls, const Body& body, const Pose2& pose, int scale) {
    core.prepare(view, body.core, pose, scale, body.radius);
    parts.prepare(view, body.parts, pose, scale, body.radius);
    rows = upright_rows(view, body, pose, scale).value_or(0);
    unhidden = !walls || in_plain_view(view, *walls, {pose.x, pose.y}, (1 + most_move) * body.radius);
}

}  // namespace roomfix
