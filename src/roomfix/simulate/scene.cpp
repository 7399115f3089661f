#include "roomfix/simulate/scene.hpp"

#include <cmath>

namespace roomfix {

using Eigen::Vector3f;

std::vector<Solid> robot_solids(const Shape& shape, const RobotLook& look, const Pose2& pose) {
    const Eigen::Vector3d half_nominal = half_size(shape);
    const Vector3f half = (half_nominal + 0.5 * look.size_error).cast<float>();
    const Material body{look.body, 0.05f, 0.03f};
    const Material top{look.top, 0.05f, 0.04f};
    const Material rubber{0.05f, 0.2f, 0.02f};
    const Eigen::Vector2f yaw(static_cast<float>(std::cos(pose.yaw)), static_cast<float>(std::sin(pose.yaw)));
    const auto place = [&](float x, float y, float z) -> Vector3f {
        return {static_cast<float>(pose.x) + yaw.x() * x - yaw.y() * y, static_cast<float>(pose.y) + yaw.y() * x + yaw.x() * y, z};
    };
    std::vector<Solid> solids;
    if (std::holds_alternative<Cylinder>(shape)) {
        solids.push_back({true, place(0, 0, half.z()), half, yaw, body, top});
        return solids;
    }
    const float height = 2 * half.z();
    const float track_top = 0.35f * height;
    const float track_half = 0.2f * half.y();
    solids.push_back({false, place(0, 0, 0.5f * (track_top + height)), {half.x(), half.y(), 0.5f * (height - track_top)}, yaw, body, top});
    for (const float side : {-1.0f, 1.0f}) {
        const float y = side * (half.y() - track_half);
        solids.push_back({false, place(0, y, 0.5f * track_top), {half.x(), track_half, 0.5f * track_top}, yaw, rubber, rubber});
        if (look.arms) {
            solids.push_back({false, place(half.x() + 0.03f, 0.5f * y, 0.45f * height), {0.03f, 0.02f, 0.02f}, yaw, rubber, rubber});
        }
    }
    // A panel on the deck and the undercarriage between the tracks.
    solids.push_back({false, place(-0.3f * half.x(), 0, height - 0.001f), {0.3f * half.x(), 0.5f * half.y(), 0.002f}, yaw, rubber, rubber});
    solids.push_back({false, place(0, 0, 0.6f * track_top), {0.95f * half.x(), half.y() - 2 * track_half, 0.4f * track_top}, yaw, rubber, rubber});
    return solids;
}

Solid placed(const Solid& solid, const Pose2& pose) {
    Solid moved = solid;
    const Eigen::Rotation2Df turn(static_cast<float>(pose.yaw));
    moved.centre.head<2>() = turn * solid.centre.head<2>() + Eigen::Vector2f(static_cast<float>(pose.x), static_cast<float>(pose.y));
    moved.axis = turn * solid.axis;
    return moved;
}

std::vector<WallPanel> panels_along(const std::vector<Polyline>& polylines, float height) {
    std::vector<WallPanel> panels;
    for (const auto& line : polylines) {
        for (std::size_t i = 1; i < line.size(); ++i) {
            panels.push_back({line[i - 1].cast<float>(), line[i].cast<float>(), height});
        }
    }
    return panels;
}

}  // namespace roomfix
