#include "roomfix/overhead/near_outlines.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "standing_camera.hpp"

namespace roomfix {
namespace {

/// A camera in a corner of the room that looks at its middle, through a lens that distorts.
View corner_camera() { return standing_camera(make_camera_model(640, 480, 450, 450, 320, 240, {-0.25, 0.06}), {-2, -1, 2.4}, {1.5, 0.5, 0}); }

/// Px of the picture that one of the masks covers and the other does not.
int difference(const BodyMask& a, const BodyMask& b) {
    std::vector<int> count(640 * 480, 0);
    for (const Span& span : a.spans) {
        for (int x = span.begin; x < span.end; ++x) ++count[static_cast<std::size_t>(span.y * 640 + x)];
    }
    for (const Span& span : b.spans) {
        for (int x = span.begin; x < span.end; ++x) --count[static_cast<std::size_t>(span.y * 640 + x)];
    }
    int different = 0;
    for (const int c : count) different += c != 0;
    return different;
}

TEST(NearOutlines, CoverWhatEachPoseCoversByItself) {
    const View view = corner_camera();
    for (const SiteRobot& robot : {SiteRobot{"can", Cylinder{0.45, 1.2}}, SiteRobot{"cart", Box{0.8, 0.5, 0.4}}}) {
        const Body body = body_of(robot);
        const Pose2 around{1.4, 0.6, 0.3};
        NearBody near;
        near.prepare(view, nullptr, body, around, 1);
        for (const Eigen::Vector3d& by :
             {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(0.03, -0.02, 0.05), Eigen::Vector3d(-0.15, 0.1, -0.4), Eigen::Vector3d(0.2, 0.05, 0.3)}) {
            const Pose2 pose{around.x + by.x(), around.y + by.y(), around.yaw + by.z()};
            ASSERT_TRUE(near.parts.reach(pose));
            BodyMask exact, fast;
            cover(view, body.parts, pose, 640, 480, 1, 1, exact);
            near.parts.cover(pose, 640, 480, 1, fast);
            ASSERT_TRUE(exact.valid && fast.valid);
            EXPECT_LT(difference(exact, fast), 0.01 * exact.area) << by.transpose();
            EXPECT_NEAR(fast.whole, exact.whole, 0.01 * exact.whole);
        }
    }
}

TEST(NearOutlines, ReachNoFartherThanTheBodyItself) {
    const Body body = body_of(SiteRobot{"cart", Box{0.8, 0.5, 0.4}});
    NearBody near;
    near.prepare(corner_camera(), nullptr, body, {1.4, 0.6, 0}, 1);
    EXPECT_FALSE(near.parts.reach({2.4, 0.6, 0}));
    EXPECT_FALSE(near.parts.reach({1.4, 0.6, 2.0}));
    near.prepare(corner_camera(), nullptr, body, {-8, -3, 0}, 1);  // behind the camera
    EXPECT_FALSE(near.parts.reach({-8, -3, 0}));
}

}  // namespace
}  // namespace roomfix
