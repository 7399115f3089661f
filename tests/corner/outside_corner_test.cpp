#include "roomfix/corner/outside_corner.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "roomfix/base/random.hpp"
#include "roomfix/corner/corner_observer.hpp"
#include "roomfix/geometry/pose.hpp"
#include "roomfix/simulate/room_shots.hpp"

namespace roomfix {
namespace {

constexpr double square_walls = std::numbers::pi / 2;

/// A plain line between two points of the map.
SceneLine drawn(const Eigen::Isometry3d& map_from_camera, const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
    const Eigen::Vector2d a = (map_from_camera.inverse() * from).hnormalized();
    const Eigen::Vector2d b = (map_from_camera.inverse() * to).hnormalized();
    SceneLine line;
    const Eigen::Vector2d along = (b - a).normalized();
    line.normal = {along.y(), -along.x()};
    line.distance = line.normal.dot(a);
    line.first = along.dot(a);
    line.cell = (b - a).norm() / SceneLine::cells;
    line.last_filled = SceneLine::cells - 1;
    line.density = 0.9;
    return line;
}

/// A cupboard of 1 x 0.6 x 1 m seen from above: its corner as if it were one of the room, and the rest of its top.
struct Cupboard {
    Eigen::Isometry3d map_from_camera = looking_at({2.1, 1.9, 2.0}, {0.9, 0.5, 0.9});
    CornerView taken_for;
    std::vector<SceneLine> lines;

    Cupboard() {
        const Eigen::Vector3d corner(1, 0.6, 1);
        const auto seen = [&](const Eigen::Vector3d& p) { return Eigen::Vector2d((map_from_camera.inverse() * p).hnormalized()); };
        CornerRays rays;
        rays.corner = seen(corner);
        const std::array<Eigen::Vector3d, 3> ends = {Eigen::Vector3d(0.5, 0.6, 1), {1, 0.3, 1}, {1, 0.6, 0.5}};
        for (std::size_t i = 0; i < 3; ++i) rays.directions[i] = (seen(ends[i]) - rays.corner).normalized();
        for (const CornerRays& labelled : labellings(rays)) {
            const CornerSolutions solutions = solve_corner(labelled, square_walls);
            const bool is_walls = (labelled.directions[wall_edge] - rays.directions[2]).norm() < 1e-12;
            if (is_walls && solutions.count > 0) taken_for = solutions.views[0];
        }
        lines = {drawn(map_from_camera, {0.2, 0, 1}, {0.9, 0, 1}), drawn(map_from_camera, {0, 0.1, 1}, {0, 0.5, 1})};
    }
};

TEST(OutsideCorner, TheOtherEdgesOfACupboardTellThatItStandsOut) {
    const Cupboard cupboard;
    ASSERT_GT(cupboard.taken_for.place.norm(), 0) << "it passes for a corner of a room";
    const CornerCompanions found = companions_of(cupboard.taken_for, square_walls, cupboard.lines, room_camera());
    EXPECT_GT(found.outside, 200);
    EXPECT_EQ(found.inside, 0);
}

TEST(OutsideCorner, LinesOfTheRoomTellThatItIsOne) {
    Random random(41);
    for (int i = 0; i < 200; ++i) {
        const Eigen::Vector3d corner(0, 0, 2.7);
        const Eigen::Isometry3d camera = look_at_corner({random.uniform(0.7, 3), random.uniform(0.7, 3)}, corner, random);
        const Eigen::Vector3d from_corner = camera.translation() - corner;
        const CornerView view{camera.linear(), from_corner.head<2>() / -from_corner.z()};
        const std::vector<SceneLine> door = {drawn(camera, {0.5, 0, 2.0}, {1.2, 0, 2.0}), drawn(camera, {0.5, 0, 2.0}, {0.5, 0, 1.5})};
        const CornerCompanions found = companions_of(view, square_walls, door, room_camera());
        EXPECT_GT(found.inside, 0);
        EXPECT_EQ(found.outside, 0);
    }
}

TEST(OutsideCorner, GrainAndShortLinesAreNotAsked) {
    Cupboard cupboard;
    for (SceneLine& line : cupboard.lines) line.density = 0.4;
    EXPECT_EQ(companions_of(cupboard.taken_for, square_walls, cupboard.lines, room_camera()).outside, 0);
    const std::vector<SceneLine> stub = {drawn(cupboard.map_from_camera, {0.2, 0, 1}, {0.25, 0, 1})};
    EXPECT_EQ(companions_of(cupboard.taken_for, square_walls, stub, room_camera()).outside, 0);
}

TEST(OutsideCorner, CupboardsSeenFromAboveGiveNoFix) {
    const CameraModel model = room_camera();
    CornerSettings gullible;
    gullible.outside.least_length = 1e9;
    CornerObserver observer(model, {square_walls});
    CornerObserver fooled(model, {square_walls}, gullible);
    RoomRenderer renderer(model, room_sensor(), {}, 7);
    LumaImage frame;
    CornerResult result;
    Random random(42);
    int found = 0, found_by_fooled = 0, said = 0;
    constexpr int pictures = 12;
    for (int i = 0; i < pictures; ++i) {
        RoomShot shot = cluttered_shot(random);
        shot.scene.boxes.clear();
        shot.scene.patches.clear();
        RoomBox cupboard;
        cupboard.half = {random.uniform(0.5, 0.7), random.uniform(0.25, 0.35), 0.45};
        cupboard.centre = {2.5, cupboard.half.y(), cupboard.half.z()};
        cupboard.albedo = 0.7f;
        shot.scene.boxes.push_back(cupboard);
        const Eigen::Vector3d corner = cupboard.centre + cupboard.half;
        shot.map_from_camera = looking_at(corner + Eigen::Vector3d(random.uniform(0.7, 1.2), random.uniform(0.7, 1.2), random.uniform(0.6, 0.9)), corner);
        renderer.render(shot.scene, shot.map_from_camera, shot.light, static_cast<std::uint64_t>(i), frame);
        fooled.observe(frame, {}, result);
        found_by_fooled += !result.corners.empty();
        observer.observe(frame, {}, result);
        found += !result.corners.empty();
        said += result.reason.find("stands out") != std::string::npos;
    }
    EXPECT_EQ(found, 0);
    EXPECT_GT(found_by_fooled, pictures / 2) << "these pictures test nothing";
    EXPECT_GT(said, pictures / 2);
}

}  // namespace
}  // namespace roomfix
