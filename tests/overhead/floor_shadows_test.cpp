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
    evidence.pixels.assign(640 * 480, {0, 1});
    evidence.perhaps.assign(640 * 480, 0.0f);
    BodyMask mask;
    cover(view, body_of({"can", Cylinder{0.5, height}}).parts, {2, 1, 0}, 640, 480, 1, 1, mask);
    for (const Span& span : mask.spans) {
        for (int x = span.begin; x < span.end; ++x) {
            const auto i = static_cast<std::size_t>(span.y * 640 + x);
            evidence.pixels[i] = {0.05f, 0.02f};
            evidence.perhaps[i] = 0.25f * 0.5f;
        }
    }
    evidence.sum_up();
    return evidence;
}

double sum_of_other(const Evidence& evidence) {
    double sum = 0;
    for (const Evidence::Sums& pixel : evidence.pixels) sum += static_cast<double>(pixel.other);
    return sum;
}

struct Pair {
    View left = camera_at({-2, 0, 2.2}), right = camera_at({2, -3, 2.4});
    std::vector<Evidence> evidence;

    explicit Pair(double height) : evidence({doubtful_cylinder(left, height), doubtful_cylinder(right, height)}) {}
    /// How much more is told to stand there, by all cameras together, than before.
    double gain() {
        const std::vector<Evidence> seen = evidence;
        const std::vector<SeenBy> cameras = {{&left, &seen[0]}, {&right, &seen[1]}};
        rule_out_shadows(cameras, evidence);
        return (sum_of_other(evidence[0]) + sum_of_other(evidence[1])) / (sum_of_other(seen[0]) + sum_of_other(seen[1]));
    }
};

TEST(FloorShadows, AShadowThatAllCamerasSeeOnTheFloorStaysOne) { EXPECT_LT(Pair(0.002).gain(), 1.3); }

TEST(FloorShadows, WhatStandsHidesFloorThatAnotherCameraSees) { EXPECT_GT(Pair(1.2).gain(), 5); }

TEST(FloorShadows, WhatNoOtherCameraSeesStaysInDoubt) {
    Pair pair(1.2);
    const Evidence alone = pair.evidence[0];
    const std::vector<SeenBy> cameras = {{&pair.left, &alone}};
    rule_out_shadows(cameras, {pair.evidence.data(), 1});
    EXPECT_EQ(sum_of_other(pair.evidence[0]), sum_of_other(alone));
}

TEST(FloorShadows, BehindAWallNothingIsRuledOut) {
    Pair pair(1.2);
    const std::vector<Evidence> seen = pair.evidence;
    const std::vector<Polyline> wall = {{{-1, -1.2}, {6, -1.2}}};  // between the right camera and the floor
    const std::vector<SeenBy> cameras = {{&pair.left, &seen[0]}, {&pair.right, &seen[1], &wall}};
    rule_out_shadows(cameras, pair.evidence);
    EXPECT_EQ(sum_of_other(pair.evidence[0]), sum_of_other(seen[0]));
}

}  // namespace
}  // namespace roomfix
