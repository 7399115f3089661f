#include "roomfix/overhead/outline_fit.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "overhead/first_aisle.hpp"
#include "roomfix/base/decompositions.hpp"
#include "roomfix/overhead/body.hpp"

namespace roomfix {
namespace {

/// A tower: a narrow box on a wide one, in the first aisle of the li2014 scenario.
class OutlineOfParts : public FirstAisle {
protected:
    OutlineOfParts() : FirstAisle(33, 5) {
        SiteRobot robot;
        robot.parts = {part_of(wide), part_of(narrow)};
        parts_ = outline_parts(robot);
    }

    static ConvexPart part_of(const Box& box) {
        ConvexPart part;
        for (int i = 0; i < 8; ++i) {
            part.points.emplace_back((i & 1 ? 0.5 : -0.5) * box.length, (i & 2 ? 0.5 : -0.5) * box.width, i & 4 ? box.height : 0);
        }
        return part;
    }

    OutlineFit fit(const Pose2& truth, const Pose2& start, const std::vector<ShapePoints>& parts) {
        std::vector<Solid> solids = robot_solids(wide, scenario_.robots[0].look, truth);
        for (const Solid& solid : robot_solids(narrow, scenario_.robots[0].look, truth)) solids.push_back(solid);
        show(solids);
        return fit_outline({frame_, &background_, &foreground_, &foreground_.mask}, view_, parts, start, {});
    }

    static constexpr Box wide{0.60, 0.36, 0.30};
    static constexpr Box narrow{0.24, 0.24, 0.70};
    std::vector<ShapePoints> parts_;
};

TEST_F(OutlineOfParts, TellsWhereTheBodyStandsAndIsAsGoodAsItStates) {
    double squares = 0;
    int count = 0;
    for (const double yaw : {-1.2, -0.5, 0.2, 0.9, 1.5}) {
        for (const double x : {5.6, 6.4}) {
            const Pose2 truth{x, 5.75, yaw};
            const OutlineFit found = fit(truth, {x + 0.05, 5.72, yaw + 0.1}, parts_);
            ASSERT_TRUE(found.determined);
            const Eigen::Vector3d error = pose_difference(truth, found.pose, parts_.front());
            EXPECT_LT(error.head<2>().norm(), 0.03) << x << " " << yaw;
            EXPECT_LT(std::abs(error.z()), 0.03) << x << " " << yaw;
            EXPECT_GT(found.right, 0) << x << " " << yaw;
            squares += error.dot(found.covariance.inverse() * error) / 3;
            ++count;
        }
    }
    EXPECT_LT(squares / count, 2.5) << "NEES per unknown";
}

TEST_F(OutlineOfParts, TurnedOtherwiseItIsNotRight) {
    const Pose2 truth{6.0, 5.75, 0.3};
    const OutlineFit right = fit(truth, truth, parts_);
    const OutlineFit wrong = fit(truth, {truth.x, truth.y, truth.yaw + std::numbers::pi / 2}, parts_);
    EXPECT_GT(right.right, wrong.right + 5);
    EXPECT_GT(right.present, 3);
}

TEST_F(OutlineOfParts, WhatHasOtherEdgesIsNotIt) {
    const Pose2 truth{6.0, 5.75, 0.3};
    SiteRobot other;
    other.parts = {part_of({0.9, 0.2, 0.15}), part_of({0.1, 0.1, 1.2})};
    EXPECT_LT(fit(truth, truth, outline_parts(other)).present, -3);
}

TEST_F(OutlineOfParts, WhereAPartIsCoveredByAnotherNoEdgeIsExpected) {
    const Pose2 truth{6.0, 5.75, 0.3};
    SiteRobot robot;
    robot.parts = {part_of(wide), part_of({0.3, 0.2, 0.2})};  // all of the second is inside the first
    const OutlineFit hollow = fit(truth, truth, {parts_.front()});
    frames_ = 0;
    const OutlineFit filled = fit(truth, truth, outline_parts(robot));
    EXPECT_EQ(filled.total, hollow.total);
    EXPECT_EQ(filled.pose.x, hollow.pose.x);
    EXPECT_EQ(filled.pose.yaw, hollow.pose.yaw);
}

TEST(OutlineParts, AreThoseOfTheRobotWithWhatIsTrueOfTheWholeBody) {
    SiteRobot robot;
    robot.size_sigma = 0.004;
    EXPECT_EQ(outline_parts(robot).size(), 1U) << "a shape is one part";
    ConvexPart low, high;
    for (int i = 0; i < 8; ++i) {
        low.points.emplace_back(i & 1 ? 0.3 : -0.3, i & 2 ? 0.2 : -0.2, i & 4 ? 0.3 : 0);
        high.points.emplace_back(i & 1 ? 0.1 : -0.1, i & 2 ? 0.1 : -0.1, i & 4 ? 0.8 : 0.3);
    }
    robot.parts = {low, high};
    const std::vector<ShapePoints> parts = outline_parts(robot);
    ASSERT_EQ(parts.size(), 2U);
    for (const ShapePoints& part : parts) {
        EXPECT_EQ(part.count, 8);
        EXPECT_DOUBLE_EQ(part.height, 0.8);
        EXPECT_NEAR(part.radius, std::hypot(0.3, 0.2), 1e-12);
        EXPECT_NEAR(part.symmetry, std::numbers::pi, 1e-9);
        EXPECT_DOUBLE_EQ(part.size_sigma, 0.004);
    }
    robot.parts[1].points.resize(ShapePoints::capacity + 1, {0, 0, 0.5});
    EXPECT_TRUE(outline_parts(robot).empty()) << "too many corners for a fit";
}

}  // namespace
}  // namespace roomfix
