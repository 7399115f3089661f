#include "roomfix/calibrate/body_learner.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <deque>
#include <numbers>

#include "roomfix/geometry/pose.hpp"
#include "roomfix/overhead/body_observer.hpp"
#include "roomfix/site/body_parts.hpp"
#include "standing_camera.hpp"

namespace roomfix {
namespace {

constexpr int width = 320;
constexpr int height = 240;
constexpr double pi = std::numbers::pi;

/// A camera 3 m above the floor that looks down at (1, 1).
View camera() {
    UncertainPose3 pose;
    pose.pose = Eigen::Isometry3d::Identity();
    pose.pose.linear() << 1, 0, 0, 0, -1, 0, 0, 0, -1;
    pose.pose.translation() = Eigen::Vector3d(1, 1, 3);
    pose.covariance = 1e-6 * Matrix6d::Identity();
    return View(make_camera_model(width, height, 300, 300, 160, 120), pose);
}

/// Something flat at a height (m) on the floor: half its size, and its colour at a place of its own (m from its middle).
struct Thing {
    Pose2 pose;
    Eigen::Vector2d half;
    double top = 0;
    std::array<float, 3> front{}, back{};
};

/// What the camera shows of things on a floor of one colour.
Evidence picture_of(const View& view, const std::vector<Thing>& things) {
    Evidence evidence;
    evidence.width = width;
    evidence.height = height;
    evidence.with_colours = true;
    evidence.channels = 3;
    evidence.pixels.assign(width * height, {0, Evidence::certain});
    evidence.as_background.assign(width * height, 5.0f);
    evidence.colours.assign(3 * width * height, 4.6f);
    for (const Thing& thing : things) {
        for (int y = 0; y < height; ++y) {
            for (int x = 0; x < width; ++x) {
                const auto seen = pixel_to_plane(view, Eigen::Vector2d(x, y), thing.top);
                if (!seen) continue;
                const Eigen::Vector2d own = Eigen::Rotation2Dd(-thing.pose.yaw) * (seen->point - Eigen::Vector2d(thing.pose.x, thing.pose.y));
                if (std::abs(own.x()) > thing.half.x() || std::abs(own.y()) > thing.half.y()) continue;
                const auto pixel = static_cast<std::size_t>(y * width + x);
                evidence.pixels[pixel] = {Evidence::certain, 0};
                evidence.as_background[pixel] = -20;
                // A wedge points forward, as an arrow on a roof does.
                const bool wedge = own.x() > -0.6 * thing.half.x() && std::abs(own.y()) < 0.5 * (thing.half.x() - own.x()) * thing.half.y() / thing.half.x();
                for (std::size_t k = 0; k < 3; ++k) evidence.colours[3 * pixel + k] = wedge ? thing.front[k] : thing.back[k];
            }
        }
    }
    evidence.sum_up();
    return evidence;
}

const SiteRobot cart{"cart", Box{0.36, 0.24, 0.15}};

Thing robot_at(double x, double y, double yaw) { return {{x, y, yaw}, {0.18, 0.12}, 0.15, {4.4f, 4.5f, 3.0f}, {5.4f, 5.3f, 5.3f}}; }
Thing paper_at(double x, double y, double yaw) { return {{x, y, yaw}, {0.15, 0.10}, 0, {3.2f, 3.2f, 5.2f}, {3.2f, 3.2f, 5.2f}}; }

struct Pictures {
    View view = camera();
    std::deque<Evidence> evidence;
    std::vector<BodyMoment> moments;

    void add(const std::vector<Thing>& things) {
        evidence.push_back(picture_of(view, things));
        moments.push_back({{{&view, &evidence.back()}}});
    }
};

const std::vector<Pose2> stops = {{0.4, 0.7, 0.3}, {1.5, 0.6, 2.0}, {1.4, 1.5, -2.4}, {0.6, 1.4, -0.9}, {1.0, 1.0, 1.2}};

TEST(BodyLearner, FindsTheRobotAmongPapersWithItsFront) {
    Pictures pictures;
    for (std::size_t i = 0; i < stops.size(); ++i) {
        const Pose2& p = stops[i];
        const double side = i % 2 == 0 ? 0.25 : 1.75;
        pictures.add({robot_at(p.x, p.y, p.yaw), paper_at(1.0, side, 0.2 * static_cast<double>(i)), paper_at(1.6, 2 - side, 1)});
    }
    const auto lesson = learn_body(pictures.moments, cart);
    ASSERT_TRUE(lesson) << lesson.error().message;
    ASSERT_EQ(lesson->sights.size(), stops.size());
    // Which end is the front nobody said: one half turn for all.
    const double turn = std::abs(wrap_angle(lesson->sights[0].pose.yaw - stops[0].yaw)) > pi / 2 ? pi : 0;
    for (const BodySight& sight : lesson->sights) {
        const Pose2& truth = stops[sight.moment];
        EXPECT_LT(std::hypot(sight.pose.x - truth.x, sight.pose.y - truth.y), 0.04) << sight.moment;
        EXPECT_LT(std::abs(wrap_angle(sight.pose.yaw - truth.yaw - turn)), 0.1) << sight.moment;
    }
    EXPECT_GT(lesson->body.as_robot.mean, lesson->body.as_clutter.mean + lesson->body.as_clutter.sigma);
    EXPECT_GT(lesson->body.size_sigma, 1e-4);

    // The body is found again in a picture that it was not learned from, and papers alone are not taken for it.
    SiteRobot learned = cart;
    learned.parts = lesson->body.parts;
    learned.learned = std::make_shared<LearnedBody>(lesson->body);
    const Body body = body_of(learned);
    Pictures other;
    other.add({paper_at(0.5, 1.2, 0.4), robot_at(1.3, 0.9, -1.5)});
    other.add({paper_at(0.5, 1.2, 0.4), paper_at(1.3, 0.9, -1.5)});
    BodySearch search;
    const auto places = search.places(other.moments[0].cameras, body, search.candidates(other.moments[0].cameras, body));
    ASSERT_FALSE(places.empty());
    EXPECT_LT(std::hypot(places[0].pose.x - 1.3, places[0].pose.y - 0.9), 0.04);
    EXPECT_LT(std::abs(wrap_angle(places[0].pose.yaw + 1.5 - turn)), 0.1);
    EXPECT_GT(places[0].probability, 0.9);
    EXPECT_LT(std::sqrt(places[0].covariance(0, 0)), 0.05) << "a look has a narrow peak";
    EXPECT_LT(std::sqrt(places[0].covariance(2, 2)), 0.3);
    const auto none = search.places(other.moments[1].cameras, body, search.candidates(other.moments[1].cameras, body));
    if (!none.empty()) {
        EXPECT_LT(none[0].probability, 0.5);
    }

    // In other light: darker, and dark colours more so than bright ones.
    Thing dim = robot_at(1.3, 0.9, -1.5);
    for (auto* colour : {&dim.front, &dim.back}) {
        for (float& c : *colour) c += -0.3f + 0.3f * (c - 5);
    }
    // A tall thing stands so near that a wider one there would reach into the robot.
    const Thing near_by{{1.56, 0.9, 0}, {0.12, 0.2}, 0.6, {3.2f, 3.2f, 3.2f}, {3.2f, 3.2f, 3.2f}};
    other.add({dim});
    other.add({near_by, robot_at(1.3, 0.9, -1.5)});
    BodyObserver observer({learned});
    for (std::size_t moment = 2; moment < 4; ++moment) {
        const auto& found = observer.find(other.moments[moment].cameras, {1});
        ASSERT_EQ(found.size(), 1U) << moment;
        EXPECT_LT(std::hypot(found[0].place.pose.x - 1.3, found[0].place.pose.y - 0.9), 0.04) << moment;
        EXPECT_LT(std::abs(wrap_angle(found[0].place.pose.yaw + 1.5 - turn)), 0.1) << moment;
    }
}

TEST(BodyLearner, PicturesWithoutARobotTeachNothing) {
    Pictures empty;
    for (int i = 0; i < 4; ++i) empty.add({});
    const auto nothing = learn_body(empty.moments, cart);
    ASSERT_FALSE(nothing);
    EXPECT_NE(nothing.error().message.find("--background"), std::string::npos) << nothing.error().message;
}

TEST(BodyLearner, WhatNeverMovesIsNoRobot) {
    Pictures furniture;
    for (int i = 0; i < 5; ++i) furniture.add({robot_at(1.2, 0.8, 0.5)});
    EXPECT_FALSE(learn_body(furniture.moments, cart));
}

TEST(BodyLearner, WhatHasAnotherSizeIsNotTheRobot) {
    Pictures pictures;
    for (const Pose2& p : stops) pictures.add({{p, {0.05, 0.04}, 0.15, {4.4f, 4.5f, 3.0f}, {5.4f, 5.3f, 5.3f}}});
    EXPECT_FALSE(learn_body(pictures.moments, {"truck", Box{0.9, 0.6, 0.15}}));
}

/// A camera at a corner of the room, 2.5 m high, that looks at (1, 1).
View corner_camera(double x, double y) { return standing_camera(make_camera_model(width, height, 220, 220, 160, 120), {x, y, 2.5}, {1, 1, 0.4}); }

TEST(BodyLearner, ARoughCylinderBecomesThePostOnABaseThatItIs) {
    // The site file says: a cylinder of 0.5 x 1.4 m.
    const Body truth = body_of({"post",
                                Cylinder{0.5, 1.4},
                                {box_part({0.5, 0.5, 0.3}, Eigen::Isometry3d(Eigen::Translation3d(0, 0, 0.15))),
                                 box_part({0.28, 0.28, 1.1}, Eigen::Isometry3d(Eigen::Translation3d(0, 0, 0.85)))}});
    const std::array<View, 4> views = {corner_camera(-1.5, -1.5), corner_camera(3.5, -1.5), corner_camera(3.5, 3.5), corner_camera(-1.5, 3.5)};
    std::deque<Evidence> evidence;
    std::vector<BodyMoment> moments;
    BodyMask mask;
    for (const Pose2& p : stops) {
        BodyMoment moment;
        for (const View& view : views) {
            Evidence& seen = evidence.emplace_back(picture_of(view, {}));
            cover(view, truth.parts, p, width, height, 1, 1, mask);
            for (const Span& span : mask.spans) {
                for (int x = span.begin; x < span.end; ++x) {
                    const auto pixel = static_cast<std::size_t>(span.y * width + x);
                    seen.pixels[pixel] = {Evidence::certain, 0};
                    for (std::size_t k = 0; k < 3; ++k) seen.colours[3 * pixel + k] = 3.5f;
                }
            }
            seen.sum_up();
            moment.cameras.push_back({&view, &seen});
        }
        moments.push_back(moment);
    }
    const auto lesson = learn_body(moments, {"post", Cylinder{0.5, 1.4}});
    ASSERT_TRUE(lesson) << lesson.error().message;
    double base = 0;
    double post = 0;
    for (const ConvexPart& part : lesson->body.parts) {
        for (const Eigen::Vector3d& q : part.points) {
            double& radius = q.z() < 0.25 ? base : post;
            if (q.z() < 0.25 || q.z() > 0.6) radius = std::max(radius, q.head<2>().norm());
        }
    }
    EXPECT_GT(base, 0.24);
    EXPECT_LT(post, 0.24);
    EXPECT_EQ(lesson->body.symmetry, 0);
    for (const BodySight& sight : lesson->sights) {
        EXPECT_LT(std::hypot(sight.pose.x - stops[sight.moment].x, sight.pose.y - stops[sight.moment].y), 0.03) << sight.moment;
    }
}

}  // namespace
}  // namespace roomfix
