#include "roomfix/simulate/room_shots.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "roomfix/base/random_vector.hpp"
#include "roomfix/geometry/pose.hpp"
#include "roomfix/geometry/view.hpp"

namespace roomfix {
namespace {

float toned(Random& random, double low, double high) { return static_cast<float>(random.uniform(low, high)); }

/// A rectangular room with its corner at the origin, walls along +x and +y.
RoomScene bare_room(double length, double width, double height, Random& random) {
    RoomScene scene;
    scene.walls = {{0, 0}, {length, 0}, {length, width}, {0, width}};
    for (int i = 0; i < 4; ++i) scene.wall_albedo.push_back(toned(random, 0.45, 0.75));
    scene.height = height;
    scene.ceiling_albedo = toned(random, 0.75, 0.9);
    scene.seed = random.bits();
    scene.lamps.push_back({{random.uniform(0.4, 0.6) * length, random.uniform(0.4, 0.6) * width, height - 0.4}, toned(random, 0.3, 0.8)});
    // A window in a far wall lights the corner from one side.
    scene.lamps.push_back({{length - 0.3, random.uniform(0.2, 0.8) * width, 1.4}, toned(random, 0.2, 1.2)});
    return scene;
}

/// A camera at `position` whose optical axis passes the corner within `spread` (rad) each way, rolled a little.
Eigen::Isometry3d aimed(const Eigen::Vector3d& position, const Eigen::Vector3d& target, double spread, double roll, Random& random) {
    Eigen::Isometry3d pose = looking_at(position, target);
    const double about_axis = random.normal(roll);
    const Eigen::Vector2d across = uniform2(random, {-0.7 * spread, -spread}, {0.7 * spread, spread});
    const Eigen::Vector3d off(across.x(), across.y(), about_axis);
    pose.linear() = pose.linear() * exponential_rotation(off);
    return pose;
}

void add_posters(RoomScene& scene, Random& random) {
    for (std::size_t wall = 0; wall < 4; ++wall) {
        const double length = (scene.walls[(wall + 1) % 4] - scene.walls[wall]).norm();
        const int count = random.index(3);
        for (int i = 0; i < count; ++i) {
            WallPatch poster;
            poster.wall = wall;
            const double across = random.uniform(0.2, 1.0);
            const double tall = random.uniform(0.2, 0.9);
            const double left = random.uniform(0.1, std::max(0.2, length - across - 0.1));
            const double foot = random.uniform(0.8, std::max(0.9, scene.height - tall - 0.25));
            poster.low = {left, foot};
            poster.high = {left + across, std::min(foot + tall, scene.height - 0.12)};
            poster.albedo = toned(random, 0.1, 0.9);
            poster.border = random.index(2) == 0 ? random.uniform(0.01, 0.04) : 0;
            poster.border_albedo = toned(random, 0.05, 0.9);
            poster.pattern = random.index(2) == 0 ? random.uniform(0.04, 0.2) : 0;
            scene.patches.push_back(poster);
        }
    }
}

void add_door_and_window(RoomScene& scene, Random& random) {
    for (const bool window : {false, true}) {
        if (random.index(3) == 0) continue;
        WallPatch patch;
        patch.wall = static_cast<std::size_t>(random.index(4));
        const double length = (scene.walls[(patch.wall + 1) % 4] - scene.walls[patch.wall]).norm();
        const double across = window ? random.uniform(0.8, 1.6) : 0.9;
        const double left = random.uniform(0.15, length - across - 0.15);
        patch.low = {left, window ? 0.9 : 0.0};
        patch.high = {left + across, window ? std::min(2.2, scene.height - 0.2) : 2.05};
        patch.albedo = window ? 0.3f : toned(random, 0.2, 0.85);
        patch.glow = window ? toned(random, 0.6, 2.5) : 0.0f;
        patch.border = 0.08;
        patch.border_albedo = toned(random, 0.3, 0.95);
        scene.patches.push_back(patch);
    }
}

void add_lamps(RoomScene& scene, Random& random) {
    const int count = random.index(4);
    for (int i = 0; i < count; ++i) {
        const bool tube = random.index(2) == 0;
        CeilingPanel panel;
        const double longest = tube ? 0.7 : 0.1;
        panel.half = {tube ? random.uniform(0.3, 0.7) : random.uniform(0.03, 0.1), tube ? random.uniform(0.03, 0.15) : random.uniform(0.03, 0.1)};
        panel.centre = {random.uniform(longest, scene.walls[2].x() - longest), random.uniform(longest, scene.walls[2].y() - longest)};
        panel.yaw = tube && random.index(2) == 0 ? std::numbers::pi / 2 : 0;
        panel.glow = toned(random, 0.8, 6);
        scene.panels.push_back(panel);
    }
}

void add_furniture(RoomScene& scene, const Eigen::Vector2d& camera, Random& random) {
    const int count = random.index(4);
    for (int i = 0; i < count; ++i) {
        const bool tall = random.index(2) == 0;
        RoomBox box;
        box.half = {random.uniform(0.25, 0.9), random.uniform(0.15, 0.35), 0.5 * (tall ? random.uniform(1.2, 2.2) : random.uniform(0.3, 0.9))};
        const std::size_t wall = static_cast<std::size_t>(random.index(4));
        const Eigen::Vector2d& from = scene.walls[wall];
        const Eigen::Vector2d along = scene.walls[(wall + 1) % 4] - from;
        const double length = along.norm();
        const Eigen::Vector2d inward = Eigen::Vector2d(-along.y(), along.x()) / length;
        const double slide = random.uniform(box.half.x(), std::max(box.half.x() + 0.01, length - box.half.x()));
        const Eigen::Vector2d middle = from + along / length * slide + inward * (box.half.y() + random.uniform(0.0, 0.05));
        box.centre = {middle.x(), middle.y(), box.half.z()};
        box.yaw = std::atan2(along.y(), along.x());
        box.albedo = toned(random, 0.1, 0.85);
        if ((middle - camera).norm() < 1.1 * box.half.norm() + 0.3) continue;
        scene.boxes.push_back(box);
    }
}

/// Many a room has one paint for all walls, and a crack or a seam of filler where they meet.
void paint_alike(RoomScene& scene, Random& random) {
    if (random.index(2) == 0) scene.wall_albedo.assign(scene.wall_albedo.size(), toned(random, 0.45, 0.75));
    if (random.index(2) == 0) return;
    scene.crease = random.uniform(0.003, 0.010);
    scene.crease_depth = toned(random, 0.05, 0.3);  // photographs of real rooms show 5 to 15 %, blurred by the lens
}

/// Cables, pipes and joints between panels: upright lines that are no edge between walls.
void add_upright_lines(RoomScene& scene, Random& random) {
    const int count = random.index(4);
    for (int i = 0; i < count; ++i) {
        WallPatch line;
        line.wall = static_cast<std::size_t>(random.index(4));
        const double length = (scene.walls[(line.wall + 1) % 4] - scene.walls[line.wall]).norm();
        const double left = random.uniform(0.05, length - 0.1);
        line.low = {left, random.index(2) == 0 ? 0 : random.uniform(0.3, 1.5)};
        line.high = {left + random.uniform(0.004, 0.03), scene.height};
        line.albedo = toned(random, 0.1, 0.9);
        scene.patches.push_back(line);
    }
}

RoomScene furnished_room(const Eigen::Vector2d& camera, Walls walls, double& corner_height, Random& random) {
    const Eigen::Vector3d size = uniform3(random, {4.5, 4.5, 2.4}, {7, 6, 3.0});
    RoomScene scene = bare_room(size.x(), size.y(), size.z(), random);
    scene.texture = toned(random, 0.01, 0.06);
    scene.texture_size = random.uniform(0.02, 0.15);
    if (walls == Walls::hard) {
        paint_alike(scene, random);
        add_upright_lines(scene, random);
    }
    add_posters(scene, random);
    add_door_and_window(scene, random);
    add_lamps(scene, random);
    add_furniture(scene, camera, random);
    corner_height = scene.height;
    if (random.index(2) == 0) {
        scene.moulding = random.uniform(0.04, 0.10);
        scene.moulding_albedo = toned(random, 0.75, 0.92);
        corner_height -= scene.moulding;
    }
    return scene;
}

}  // namespace

CameraModel room_camera() { return make_camera_model(640, 480, 600, 600, 322.4, 237.1, {-0.11, 0.05, 0.0005, -0.0007, 0}); }

SensorModel room_sensor() {
    SensorModel sensor;
    sensor.blur = 0.8;
    sensor.exposure = 1.3;  // a white ceiling comes out bright, not white
    sensor.read_noise = 1;
    sensor.shot_noise = 0.01;
    return sensor;
}

const std::vector<Eigen::Vector2d>& chou1986_places() {
    static const std::vector<Eigen::Vector2d> places = [] {
        std::vector<Eigen::Vector2d> grid;
        for (const double y : {0.7, 1.4, 2.1, 2.8}) {
            for (const double x : {0.7, 1.4, 2.1, 2.8}) grid.emplace_back(x, y);
        }
        return grid;
    }();
    return places;
}

Eigen::Isometry3d look_at_corner(const Eigen::Vector2d& place, const Eigen::Vector3d& corner, Random& random) {
    return aimed({place.x(), place.y(), chou1986_camera_height}, corner, 0.14, 0.05, random);
}

RoomShot chou1986_shot(const Eigen::Vector2d& place, Random& random) {
    RoomShot shot;
    shot.scene = bare_room(6, 5, chou1986_ceiling, random);
    // The paper needs "different lighting on each wall".
    shot.scene.wall_albedo[0] = toned(random, 0.55, 0.65);
    shot.scene.wall_albedo[3] = toned(random, 0.35, 0.45);
    if (random.index(2) == 0) std::swap(shot.scene.wall_albedo[0], shot.scene.wall_albedo[3]);
    shot.corner = {"c", {0, 0, chou1986_ceiling}, 0};
    shot.map_from_camera = look_at_corner(place, shot.corner.position, random);
    shot.light = 1 + random.normal(0.05);
    return shot;
}

RoomShot cluttered_shot(Random& random, Walls walls) {
    RoomShot shot;
    const Eigen::Vector2d place = uniform2(random, {1, 1}, {4, 4});
    double corner_height = 0;
    shot.scene = furnished_room(place, walls, corner_height, random);
    shot.corner = {"c", {0, 0, corner_height}, 0};
    shot.map_from_camera = aimed({place.x(), place.y(), random.uniform(0.5, 1.2)}, shot.corner.position, 0.2, 0.05, random);
    shot.light = 1 + random.normal(0.1);
    return shot;
}

RoomShot cornerless_shot(Random& random, Walls walls) {
    for (;;) {
        RoomShot shot;
        const Eigen::Vector2d place = uniform2(random, {1, 1}, {3.5, 3.5});
        double corner_height = 0;
        shot.scene = furnished_room(place, walls, corner_height, random);
        const Eigen::Vector3d position(place.x(), place.y(), random.uniform(0.5, 1.2));
        const double heading = random.uniform(-std::numbers::pi, std::numbers::pi);
        const double rise = random.uniform(-0.3, 0.8);
        shot.map_from_camera = aimed(position, position + Eigen::Vector3d(std::cos(heading), std::sin(heading), std::tan(rise)), 0.05, 0.05, random);
        shot.light = 1 + random.normal(0.1);
        const View view{room_camera(), {shot.map_from_camera, Matrix6d::Zero()}};
        const auto in_sight = [&](const Eigen::Vector2d& wall_corner) {
            const auto top = project_map_point(view, {wall_corner.x(), wall_corner.y(), shot.scene.height});
            const auto foot = project_map_point(view, {wall_corner.x(), wall_corner.y(), corner_height});
            return (top && view.model.contains(*top, -8)) || (foot && view.model.contains(*foot, -8));
        };
        if (std::none_of(shot.scene.walls.begin(), shot.scene.walls.end(), in_sight)) return shot;
    }
}

std::array<double, 3> visible_edges(const RoomShot& shot, const CameraModel& model, RoomRenderer& renderer, double contrast) {
    RoomScene smooth = shot.scene;
    smooth.texture = 0;
    const std::vector<float>& exposed = renderer.expose(smooth, shot.map_from_camera, shot.light);
    const View view{model, {shot.map_from_camera, Matrix6d::Zero()}};
    const auto grey = [&](const Eigen::Vector2d& p) {
        return static_cast<double>(exposed[static_cast<std::size_t>(std::lround(p.y()) * model.width + std::lround(p.x()))]);
    };
    std::array<double, 3> lengths{};
    const std::array<Eigen::Vector3d, 3> along = {Eigen::Vector3d(std::cos(shot.corner.yaw), std::sin(shot.corner.yaw), 0),
                                                  Eigen::Vector3d(-std::sin(shot.corner.yaw), std::cos(shot.corner.yaw), 0), -Eigen::Vector3d::UnitZ()};
    for (std::size_t i = 0; i < 3; ++i) {
        std::optional<Eigen::Vector2d> before;
        for (double run = 0; run < 4; run += 0.005) {
            const auto pixel = project_map_point(view, shot.corner.position + run * along[i]);
            if (!pixel || !model.contains(*pixel, 6)) break;
            if (before && (*pixel - *before).norm() > 1e-6) {
                const Eigen::Vector2d step = *pixel - *before;
                const Eigen::Vector2d normal = Eigen::Vector2d(-step.y(), step.x()).normalized();
                // The change must sit at the edge itself, not somewhere near it.
                const double change = std::abs(grey(*pixel + 2.5 * normal) - grey(*pixel - 2.5 * normal));
                const double before_it = std::abs(grey(*pixel + 2.5 * normal) - grey(*pixel + 5 * normal));
                const double after_it = std::abs(grey(*pixel - 2.5 * normal) - grey(*pixel - 5 * normal));
                const double crease = std::abs(grey(*pixel) - 0.5 * (grey(*pixel + 4 * normal) + grey(*pixel - 4 * normal)));
                const bool is_crease = i == 2 && crease > contrast;
                if (is_crease || (change > contrast && change > 2 * std::max(before_it, after_it))) lengths[i] += step.norm();
            }
            before = *pixel;
        }
    }
    return lengths;
}

}  // namespace roomfix
