// Looks at a room's corner with exact truth: the experiment of Chou and Tsai 1986, the same in rooms full of things, and looks at no corner.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <vector>

#include "roomfix/base/random.hpp"
#include "roomfix/simulate/room_scene.hpp"
#include "roomfix/site/site.hpp"

namespace roomfix {

/// One picture to take: the room, the camera, the corner that it looks at.
struct RoomShot {
    RoomScene scene;
    Eigen::Isometry3d map_from_camera = Eigen::Isometry3d::Identity();
    SiteCorner corner;
    double light = 1;
};

/// A camera of 640 x 480 pixels with a focal length of 600 px and a lens that bends a little.
CameraModel room_camera();
/// A webcam in a lit room: about one and a half grey levels of noise in the middle of its range.
SensorModel room_sensor();

/// The paper's experiment: the ceiling two metres above the camera, 16 places of which it prints no coordinates; here a grid from
/// 1 to 4 m away from the foot of the corner. Map = corner: x and y along the walls.
const std::vector<Eigen::Vector2d>& chou1986_places();
constexpr int chou1986_pictures = 6;             // per place
constexpr double chou1986_camera_height = 0.70;  // m
constexpr double chou1986_ceiling = 2.70;        // m

/// The experiment's camera at a place, turned towards the corner, each time a little differently.
Eigen::Isometry3d look_at_corner(const Eigen::Vector2d& place, const Eigen::Vector3d& corner, Random& random);

/// A room with bare, textured walls; the camera stands at `place` and looks at the corner, each time a little differently.
RoomShot chou1986_shot(const Eigen::Vector2d& place, Random& random);

/// Walls each with a paint of its own, or hard to tell apart: often of one paint, with a crease where they meet, cables and pipes on them.
enum class Walls { plain, hard };

/// A furnished room: posters, a door, a window, lamps, mouldings in every other one, a wardrobe or two; the camera 1 to 4 m from each
/// wall. With a moulding the corner is where the walls' edge meets the moulding from below.
RoomShot cluttered_shot(Random& random, Walls walls = Walls::plain);

/// A furnished room whose corners are all out of the picture.
RoomShot cornerless_shot(Random& random, Walls walls = Walls::plain);

/// How much of the corner a picture shows: for each edge (x, y, walls) the length in px over which the light changes across it by at least
/// `contrast` grey levels, or a crease between the walls stands out by them, without noise and without the walls' grain, which is no edge.
std::array<double, 3> visible_edges(const RoomShot& shot, const CameraModel& model, RoomRenderer& renderer, double contrast);

}  // namespace roomfix
