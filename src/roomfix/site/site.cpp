#include "roomfix/site/site.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "roomfix/geometry/floor_lens.hpp"
#include "roomfix/site/body_parts.hpp"

namespace roomfix {

std::string resolved_path(const Site& site, const std::string& path) {
    if (path.empty() || path.find("://") != std::string::npos || path.front() == '/') return path;
    return (site.folder / path).lexically_normal().string();
}

IntrinsicsErrors SiteCamera::intrinsics_errors() const {
    IntrinsicsErrors errors{intrinsics_covariance};
    if (const auto* known = std::get_if<KnownPose>(&placement)) errors.pose_by = known->by_intrinsics;
    if (const auto* mount = std::get_if<Mount>(&placement)) errors.pose_by = mount->by_intrinsics;
    return errors;
}

std::vector<TagFamily> Site::tag_families() const {
    std::vector<TagFamily> families;
    const auto add = [&](const Tag& tag) {
        if (std::find(families.begin(), families.end(), tag.family) == families.end()) families.push_back(tag.family);
    };
    for (const SiteLandmark& landmark : landmarks) {
        if (const auto* tag = std::get_if<Tag>(&landmark.kind)) add(*tag);
    }
    for (const SiteRobot& robot : robots) {
        if (robot.tag) add(*robot.tag);
    }
    return families;
}

CameraOnRobot camera_on_robot(const SiteCamera& camera, const Mount& mount) { return {camera.model, mount.robot_from_camera, camera.intrinsics_errors()}; }

Result<KnownPose> known_pose(const SiteCamera& camera, std::string* note) {
    if (const auto* known = std::get_if<KnownPose>(&camera.placement)) return *known;
    if (const auto* floor = std::get_if<KnownFloorPoints>(&camera.placement)) {
        auto solved = camera_pose_from_floor_points(camera.model, floor->points, floor->sigma);
        if (!solved) return Error{fmt::format("camera {}: {}", camera.id, solved.error().message)};
        if (note && solved->rms > 4 * floor->sigma) {
            *note = fmt::format("camera {}: the floor points disagree by {:.1f} px rms; point {} is off by {:.1f} px: check it", camera.id, solved->rms,
                                solved->worst + 1, solved->worst_error);
        }
        return KnownPose{solved->map_from_camera, true, solved->by_intrinsics};
    }
    return Error{fmt::format("camera {} is not fixed in the map: only a camera with 'pose' or 'floor_points' can watch robots", camera.id)};
}

Result<View> fixed_view(const SiteCamera& camera, std::string* note) {
    const auto known = known_pose(camera, note);
    if (!known) return known.error();
    // Many exact points on the floor show where the lens is not as stated; a stated covariance is believed.
    const auto* floor = std::get_if<KnownFloorPoints>(&camera.placement);
    if (floor && camera.intrinsics_covariance.isZero(0)) {
        FloorPointsPose pose;
        pose.map_from_camera = known->map_from_camera;
        if (const auto lens = lens_from_floor_points(camera.model, pose, floor->points)) {
            if (note) {
                *note = fmt::format(
                    "camera {}: its floor points fit a focal length of {:.1f} px better than the stated {:.1f} px: that is used; calibrate its lens anew",
                    camera.id, lens->model.fx, camera.model.fx);
            }
            return View{lens->model, lens->map_from_camera, lens->intrinsics};
        }
    }
    return View{camera.model, known->map_from_camera, {camera.intrinsics_covariance, known->by_intrinsics}};
}

std::vector<Eigen::Vector3d> own_points(const LandmarkKind& kind) {
    if (const auto* triangle = std::get_if<LedTriangle>(&kind)) {
        const double x = triangle->a / 2;
        const double y = triangle->b / 2;
        return {{-x, -y, 0}, {x, -y, 0}, {-x, y, 0}};
    }
    if (std::holds_alternative<PointMark>(kind)) return {Eigen::Vector3d::Zero()};
    const double half = std::get<Tag>(kind).size / 2;
    return {{-half, -half, 0}, {half, -half, 0}, {half, half, 0}, {-half, half, 0}};
}

std::vector<Eigen::Vector3d> map_points(const SiteLandmark& landmark) {
    auto points = own_points(landmark.kind);
    for (auto& p : points) p = landmark.map_from_landmark * p;
    return points;
}

std::vector<LandmarkShape> landmark_shapes(const std::vector<SiteLandmark>& landmarks) {
    constexpr double same = 5e-4;  // m
    std::vector<LandmarkShape> shapes;
    for (std::size_t i = 0; i < landmarks.size(); ++i) {
        const double height = landmarks[i].map_from_landmark.translation().z();
        const auto* triangle = std::get_if<LedTriangle>(&landmarks[i].kind);
        const auto alike = [&](const LandmarkShape& shape) {
            const auto* other = std::get_if<LedTriangle>(&shape.kind);
            if (!triangle || !other) return false;
            return std::abs(other->a - triangle->a) < same && std::abs(other->b - triangle->b) < same && std::abs(shape.height - height) < same;
        };
        auto found = std::find_if(shapes.begin(), shapes.end(), alike);
        if (found == shapes.end()) found = shapes.insert(shapes.end(), {landmarks[i].kind, height, {}});
        found->landmarks.push_back(static_cast<int>(i));
    }
    return shapes;
}

Receiver somewhere_on(const SiteRobot& robot) {
    const Eigen::Vector3d half = half_size(robot.shape);
    Receiver receiver;
    receiver.position = {0, 0, half.z()};
    receiver.position_sigma = half / std::sqrt(3.0);
    return receiver;
}

std::optional<int> SiteRobot::receiver_index(const std::string& name) const {
    for (std::size_t i = 0; i < receivers.size(); ++i) {
        if (name.empty() || receivers[i].id == name) return static_cast<int>(i);
    }
    return std::nullopt;
}

bool wall_between(const std::vector<Polyline>& walls, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    const auto side = [](const Eigen::Vector2d& p, const Eigen::Vector2d& q, const Eigen::Vector2d& r) {
        return (q.x() - p.x()) * (r.y() - p.y()) - (q.y() - p.y()) * (r.x() - p.x()) > 0;
    };
    for (const Polyline& line : walls) {
        for (std::size_t i = 1; i < line.size(); ++i) {
            if (side(a, b, line[i - 1]) != side(a, b, line[i]) && side(line[i - 1], line[i], a) != side(line[i - 1], line[i], b)) return true;
        }
    }
    return false;
}

Eigen::Vector3d half_size(const Shape& shape) {
    if (const auto* box = std::get_if<Box>(&shape)) return {box->length / 2, box->width / 2, box->height / 2};
    const auto& cylinder = std::get<Cylinder>(shape);
    return {cylinder.diameter / 2, cylinder.diameter / 2, cylinder.height / 2};
}

bool look_alike(const SiteRobot& a, const SiteRobot& b) {
    constexpr double alike = 0.02;  // m
    if (a.shape.index() != b.shape.index() || (half_size(a.shape) - half_size(b.shape)).cwiseAbs().maxCoeff() >= alike) return false;
    return a.learned_body == b.learned_body && same_parts(a.parts, b.parts, alike);
}

std::vector<std::size_t> kinds_of(const std::vector<SiteRobot>& robots) {
    std::vector<std::size_t> kinds;
    std::size_t count = 0;
    for (const SiteRobot& robot : robots) {
        const auto alike = std::find_if(robots.data(), &robot, [&](const SiteRobot& other) { return look_alike(other, robot); });
        kinds.push_back(alike == &robot ? count++ : kinds[static_cast<std::size_t>(alike - robots.data())]);
    }
    return kinds;
}

bool hard_to_tell(const SiteRobot& a, const SiteRobot& b) {
    if (look_alike(a, b)) return true;
    constexpr double like_footprint = 1.5, like_height = 2;  // ratios of sizes: bodies fill their boxes no better than that
    const bool rough = a.parts.empty() && b.parts.empty() && !a.learned && !b.learned && !a.many && !b.many;
    const Eigen::Vector3d half_a = half_size(a.shape), half_b = half_size(b.shape);
    const auto footprint = [](const Eigen::Vector3d& half) { return std::sqrt(half.x() * half.y()); };
    const auto near = [](double p, double q, double like) { return std::max(p, q) < like * std::min(p, q); };
    return rough && near(footprint(half_a), footprint(half_b), like_footprint) && near(half_a.z(), half_b.z(), like_height);
}

}  // namespace roomfix
