// What a simulated room contains and how it is lit. Map frame, metres; light in arbitrary linear units, 1 = a white wall
// in full light.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "roomfix/geometry/pose.hpp"
#include "roomfix/site/site.hpp"

namespace roomfix {

/// How much light a surface gives back, with a grain of its own.
struct Material {
    float albedo = 0.5f;
    float grain = 0.0f;        // relative strength of the texture
    float grain_size = 0.02f;  // m
};

/// An upright box or cylinder.
struct Solid {
    bool round = false;
    Eigen::Vector3f centre = Eigen::Vector3f::Zero();
    Eigen::Vector3f half = Eigen::Vector3f::Zero();   // half sizes along its own axes; a cylinder's radius is half.x()
    Eigen::Vector2f axis = Eigen::Vector2f::UnitX();  // cosine and sine of its yaw
    Material side;
    Material top;
};

struct WallPanel {
    Eigen::Vector2f from = Eigen::Vector2f::Zero();
    Eigen::Vector2f to = Eigen::Vector2f::Zero();
    float height = 2.8f;
    Material material{0.72f, 0.02f, 0.05f};
    float skirting = 0.10f;  // height of the dark band at the floor
};

struct Lamp {
    Eigen::Vector3f position = Eigen::Vector3f::Zero();
    float power = 1;   // irradiance at 1 m, straight below
    float radius = 0;  // 0 casts a hard shadow
};

struct TiledFloor {
    float tile = 0.30f;
    float grout = 0.005f;
    float albedo = 0.55f;
    float variation = 0.05f;  // from tile to tile
    Material grain{1, 0.02f, 0.015f};
    float reflection = 0.06f;  // part of the light that is mirrored
};

struct Scene {
    TiledFloor floor;
    std::vector<WallPanel> walls;
    std::vector<Solid> furniture;
    std::vector<Lamp> lamps;
    float ambient = 0.35f;
    std::uint64_t seed = 1;
};

/// How a robot of the given shape looks: body, tracks and front arms, standing at `pose`. The body fills the shape's box;
/// the arms stick out in front, as real ones do.
struct RobotLook {
    float body = 0.16f;  // albedo
    float top = 0.30f;
    bool arms = true;
    Eigen::Vector3d size_error = Eigen::Vector3d::Zero();  // m: how far the real robot is off its data sheet
};
std::vector<Solid> robot_solids(const Shape& shape, const RobotLook& look, const Pose2& pose);

/// A solid that is given in the frame of a robot at `pose`.
Solid placed(const Solid& solid, const Pose2& pose);

/// Wall panels along polylines of the map.
std::vector<WallPanel> panels_along(const std::vector<Polyline>& polylines, float height);

}  // namespace roomfix
