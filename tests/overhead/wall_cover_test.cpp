#include "roomfix/overhead/wall_cover.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "roomfix/base/random.hpp"
#include "standing_camera.hpp"

namespace roomfix {
namespace {

/// A camera in a corner of the room that looks at its middle, a little askew, through a lens that distorts.
View askew_camera() { return standing_camera(make_camera_model(640, 480, 450, 450, 320, 240, {-0.25, 0.06}), {-2, -1, 2.4}, {1.5, 0.5, 0}, {0.08, -0.05, 1}); }

/// Does a wall stand between the camera and what a pixel shows of a body so far away?
bool hidden(const View& view, const std::vector<Polyline>& walls, int x, int y, double distance) {
    const auto ray = unproject(view.model, Eigen::Vector2d(x, y));
    if (!ray) return false;
    const Eigen::Vector2d direction = (view.map_from_camera.pose.linear() * ray->homogeneous()).head<2>().normalized();
    const Eigen::Vector2d from = view.position().head<2>();
    return wall_between(walls, from + 0.3 * direction, from + distance * direction);
}

struct Counts {
    int body = 0, left = 0, wrong = 0;  // px
};

/// What is left of a robot's pixels beside what each pixel's ray says.
Counts compare(const View& view, const std::vector<Polyline>& walls, const Body& body, const Pose2& pose) {
    BodyMask whole, seen;
    cover(view, body.parts, pose, 640, 480, 1, 1, whole);
    seen = whole;
    const WallCover cover = wall_cover(view, walls, {pose.x, pose.y}, body.radius, body.height, 1);
    take_away(cover, seen);
    std::vector<char> kept(640 * 480, 0);
    for (const Span& span : seen.spans) {
        for (int x = span.begin; x < span.end; ++x) kept[static_cast<std::size_t>(span.y * 640 + x)] = !cover.whole;
    }
    Counts counts;
    const double distance = (view.position().head<2>() - Eigen::Vector2d(pose.x, pose.y)).norm();
    for (const Span& span : whole.spans) {
        for (int x = span.begin; x < span.end; ++x) {
            const bool is_kept = kept[static_cast<std::size_t>(span.y * 640 + x)] != 0;
            ++counts.body;
            counts.left += is_kept;
            counts.wrong += is_kept == hidden(view, walls, x, span.y, distance);
        }
    }
    return counts;
}

TEST(WallCover, HidesThePixelsWhoseRaysMeetAWall) {
    const View view = askew_camera();
    const Body body = body_of({"cart", Box{0.6, 0.5, 0.7}});
    Random random(7);
    int partly = 0;
    for (int i = 0; i < 300; ++i) {
        const Pose2 pose{random.uniform(1, 2.5), random.uniform(0, 1.5), random.uniform(-3, 3)};
        const auto point = [&] { return Eigen::Vector2d(random.uniform(-1.2, 3), random.uniform(-1, 2)); };
        const std::vector<Polyline> walls = {{point(), point()}, {point(), point(), point()}};
        const bool through = std::any_of(walls.begin(), walls.end(), [&](const Polyline& wall) {
            return std::any_of(wall.begin(), wall.end(), [&](const Eigen::Vector2d& p) { return (p - Eigen::Vector2d(pose.x, pose.y)).norm() < body.radius; });
        });
        if (through) continue;  // a wall that ends inside a robot
        const Counts counts = compare(view, walls, body, pose);
        partly += counts.left > 0.1 * counts.body && counts.left < 0.9 * counts.body;
        EXPECT_LT(counts.wrong, 0.04 * counts.body + 2) << "world " << i << ": " << counts.left << " of " << counts.body << " left";
    }
    EXPECT_GT(partly, 25);
}

TEST(WallCover, AWallBehindTheRobotOrAtTheCameraHidesNothing) {
    const View view = askew_camera();
    EXPECT_TRUE(wall_cover(view, std::vector<Polyline>{{{-2.2, -3}, {-2.2, 3}}, {{3, -3}, {3, 3}}}, {1.5, 0.5}, 0.4, 0.7, 1).none());
    EXPECT_TRUE(wall_cover(view, std::vector<Polyline>{{{-1.9, -3}, {-1.9, 3}}}, {1.5, 0.5}, 0.4, 0.7, 1).none());  // on which it hangs
    EXPECT_TRUE(wall_cover(view, std::vector<Polyline>{{{0, -3}, {0, 3}}}, {1.5, 0.5}, 0.4, 0.7, 1).whole);
}

TEST(WallCover, WhatIsInPlainViewIsNowhereHidden) {
    const View view = askew_camera();
    Random random(9);
    int plain = 0, hidden_somewhere = 0;
    for (int i = 0; i < 400; ++i) {
        const auto anywhere = [&] { return Eigen::Vector2d(-1 + 5 * random.uniform(), -2 + 5 * random.uniform()); };
        const std::vector<Polyline> walls = {{anywhere(), anywhere()}};
        const Eigen::Vector2d place = anywhere();
        const double radius = 0.3, reach = 0.4;
        bool clear = true;
        for (int turn = 0; turn < 16; ++turn) {
            const double angle = 2 * std::numbers::pi * turn / 16;
            const Eigen::Vector2d beside = place + reach * Eigen::Vector2d(std::cos(angle), std::sin(angle));
            clear &= wall_cover(view, walls, beside, radius, 1, 1).none();
        }
        if (in_plain_view(view, walls, place, radius + reach)) {
            ++plain;
            EXPECT_TRUE(clear) << place.transpose();
        }
        hidden_somewhere += !clear;
    }
    EXPECT_GT(plain, 100);
    EXPECT_GT(hidden_somewhere, 50);
    EXPECT_LT(400 - plain - hidden_somewhere, 120);  // it may say no where nothing is hidden, but not often
}

}  // namespace
}  // namespace roomfix
