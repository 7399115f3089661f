#include "roomfix/overhead/floor_shadows.hpp"

#include <gtest/gtest.h>

#include "roomfix/overhead/body.hpp"

namespace roomfix {
namespace {

View camera_at(const Eigen::Vector3d& from) {
    UncertainPose3 pose;
    pose.pose = looking_at(from, {2, 1, 0});
    return {make_camera_model(640, 480, 500, 500, 320, 240), pose};
}

/// A picture in which a cylinder at (2, 1) shows what may as well be a shadow; of that, a quarter counts.
Evidence doubtful_cylinder(const View& view, double height) {
    Evidence evidence;
    evidence.width = 640;
    evidence.height = 480;
    evidence.perhaps_counts = false;
    evidence.perhaps_part = 0.25f;
    evidence.pixels.assign(640 * 480, {0, Evidence::certain});
    evidence.perhaps.assign(640 * 480, 0);
    evidence.light.assign(640 * 480, 0);
    BodyMask mask;
    cover(view, body_of({"can", Cylinder{0.5, height}}).parts, {2, 1, 0}, 640, 480, 1, 1, mask);
    for (const Span& span : mask.spans) {
        for (int x = span.begin; x < span.end; ++x) {
            const auto i = static_cast<std::size_t>(span.y * 640 + x);
            evidence.pixels[i] = {Evidence::certain / 20, Evidence::certain / 50};
            evidence.perhaps[i] = Evidence::certain / 2;
        }
    }
    evidence.sum_up();
    return evidence;
}

/// Mean over the cylinder's pixels.
double mean_other(const Evidence& evidence, const Evidence& before) {
    double sum = 0, count = 0;
    for (std::size_t i = 0; i < evidence.pixels.size(); ++i) {
        if (before.perhaps[i] == 0) continue;
        sum += static_cast<double>(evidence.at(i).other);
        ++count;
    }
    return sum / count;
}

struct Pair {
    View left = camera_at({-2, 0, 2.2}), right = camera_at({2, -3, 2.4});
    std::vector<Evidence> evidence;
    std::vector<Polyline> walls;  // that the right camera does not see through

    explicit Pair(double height) : evidence({doubtful_cylinder(left, height), doubtful_cylinder(right, height)}) {}
    /// What the cylinder's pixels in the left picture show of something else, once both cameras were asked.
    double told() {
        const std::vector<Evidence> seen = evidence;
        const std::vector<SeenBy> cameras = {{&left, &seen[0]}, {&right, &seen[1], &walls}};
        weigh_shadows(cameras, evidence);
        return mean_other(evidence[0], seen[0]);
    }
};

TEST(FloorShadows, AShadowThatAllCamerasSeeOnTheFloorStaysOne) { EXPECT_LT(Pair(0.002).told(), 0.2); }

TEST(FloorShadows, WhatLooksLighterToOneCameraThanToAnotherIsNoShadowForSure) {
    Pair pair(0.002);
    for (std::int8_t& light : pair.evidence[1].light) light = 30;
    const double told = pair.told();
    EXPECT_GT(told, 0.25);
    EXPECT_LT(told, 0.5);
}

TEST(FloorShadows, WhatStandsHidesFloorThatAnotherCameraSees) { EXPECT_GT(Pair(1.2).told(), 0.6); }

TEST(FloorShadows, WhatNoOtherCameraSeesStaysInDoubt) {
    Pair pair(1.2);
    pair.walls = {{{-1, -1.2}, {6, -1.2}}};  // between the right camera and the floor
    const double told = pair.told();
    EXPECT_GT(told, 0.25);
    EXPECT_LT(told, 0.5);
}

TEST(FloorShadows, BehindWhatStandsBeforeAWallThereIsNoFloor) {
    Pair pair(1.2);
    const Evidence before = pair.evidence[0];
    const std::vector<Polyline> wall = {{{2.6, -3}, {2.6, 4}}};  // behind the cylinder
    const std::vector<SeenBy> cameras = {{&pair.left, &before, &wall}};
    weigh_shadows(cameras, {pair.evidence.data(), 1});
    EXPECT_GT(mean_other(pair.evidence[0], before), 0.4);
}

}  // namespace
}  // namespace roomfix
