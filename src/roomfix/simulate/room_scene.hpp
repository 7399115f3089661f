// A room seen from inside: walls, ceiling and floor with what hangs on them and stands before them. Map frame, metres; light 1 is a
// white surface in full light.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "roomfix/geometry/camera_model.hpp"
#include "roomfix/imaging/luma.hpp"
#include "roomfix/simulate/pixel_rays.hpp"
#include "roomfix/simulate/row_poses.hpp"
#include "roomfix/simulate/sensor.hpp"

namespace roomfix {

/// A rectangle on a wall: a poster, a door, a window, a switch.
struct WallPatch {
    std::size_t wall = 0;
    Eigen::Vector2d low = Eigen::Vector2d::Zero();  // m: along the wall from its first point, and height above the floor
    Eigen::Vector2d high = Eigen::Vector2d::Zero();
    float albedo = 0.5f;
    float glow = 0;     // light of its own: a window
    double border = 0;  // m: width of a frame inside it
    float border_albedo = 0;
    double pattern = 0;  // m: size of the cells of what it shows; 0: plain
};

/// A lamp's lit face, a duct or a hatch on the ceiling.
struct CeilingPanel {
    Eigen::Vector2d centre = Eigen::Vector2d::Zero();
    Eigen::Vector2d half = Eigen::Vector2d::Zero();
    double yaw = 0;
    float albedo = 0.5f;
    float glow = 0;
};

/// An upright box: a wardrobe, a shelf, the frame around a door.
struct RoomBox {
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    Eigen::Vector3d half = Eigen::Vector3d::Zero();
    double yaw = 0;
    float albedo = 0.5f;
};

struct RoomLamp {
    Eigen::Vector3d position = Eigen::Vector3d::Zero();
    float power = 1;  // irradiance at 1 m
};

struct RoomScene {
    std::vector<Eigen::Vector2d> walls;  // corners of a convex floor plan, counter-clockwise
    std::vector<float> wall_albedo;      // one per wall; wall i runs from corner i to the next
    double height = 2.7;
    float ceiling_albedo = 0.85f;
    double moulding = 0;        // m: a plaster moulding's height, along the wall; 0: none
    double moulding_slope = 1;  // its reach along the ceiling over its height: 1: 45 deg; 0.1: nearly a flat strip
    std::vector<bool> moulded;  // one per wall: whether the moulding runs along it; empty: along all
    float moulding_albedo = 0.85f;
    float floor_albedo = 0.35f;
    float texture = 0.03f;       // relative grain of the walls
    double texture_size = 0.06;  // m
    double crease = 0;           // m: half the width of the dark line where two walls meet; 0: none
    float crease_depth = 0.3f;   // part of the light that is lost in it
    float ambient = 0.6f;
    float occlusion = 0.18f;         // ambient light lost beside a surface at a right angle ...
    double occlusion_size = 1.5;     // m, ... over about this distance
    std::vector<WallPatch> patches;  // later ones lie over earlier ones
    std::vector<CeilingPanel> panels;
    std::vector<RoomBox> boxes;
    std::vector<RoomLamp> lamps;
    std::uint64_t seed = 1;
};

class RoomRenderer {
public:
    RoomRenderer(const CameraModel& model, const SensorModel& sensor, const GlareModel& glare, std::uint64_t seed);

    /// The frame that a camera at `map_from_camera`, inside the room, takes. `index` picks the noise: the same index gives the same bytes.
    void render(const RoomScene& scene, const RowPoses& map_from_camera, double gain, std::uint64_t index, LumaImage& frame);

    /// The same without noise and rounding, grey levels row by row.
    const std::vector<float>& expose(const RoomScene& scene, const RowPoses& map_from_camera, double gain);

private:
    Sensor sensor_;
    int width_, height_;
    PixelRays rays_;                   // camera frame
    std::vector<float> corner_light_;  // along the rays at the pixels' corners
    std::vector<int> corner_surface_;
    std::vector<float> light_;
};

}  // namespace roomfix
