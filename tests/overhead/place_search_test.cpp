#include "roomfix/overhead/place_search.hpp"

#include <gtest/gtest.h>

#include "overhead/first_aisle.hpp"
#include "roomfix/overhead/body.hpp"

namespace roomfix {
namespace {

/// A robot in the first aisle of the li2014 scenario, of which a crate before it hides a part.
class HalfHiddenRobot : public FirstAisle {
protected:
    HalfHiddenRobot() : FirstAisle(34, 6) {}

    /// Where it is found when it is thought to be at `guess` and the left part of its picture is hidden.
    PlaceSearch::Result find(const Pose2& truth, const Pose2& guess, double hidden_part) {
        show(robot_solids(robot, scenario_.robots[0].look, truth));
        const Silhouette whole = project_silhouette(view_, shape_, truth);
        const PixelBox box = box_around(whole.polygon());
        // What hides it was there before: the frame shows the background.
        const int until = static_cast<int>(box.low.x() + hidden_part * (box.high.x() - box.low.x()));
        for (int y = 0; y < frame_.height(); ++y) {
            for (int x = 0; x < until; ++x) frame_.row(y)[x] = background_.mean().at(x, y);
        }
        background_.classify_solid(frame_, foreground_);
        const ForegroundMasks masks{&foreground_.mask, &foreground_.shadow};
        const auto& components = finder_.find(foreground_.mask, 200);
        if (components.empty()) return {};
        return search_.find({frame_, &background_, &foreground_, &foreground_.mask}, masks, view_, shape_, measure_blob(masks, components.front()), guess, {},
                            {});
    }

    static constexpr Box robot{0.60, 0.36, 0.30};
    const ShapePoints shape_ = shape_points(robot, 0.005);
    ComponentFinder finder_;
    PlaceSearch search_;
};

TEST_F(HalfHiddenRobot, IsFoundByWhatIsLeftOfItsOutline) {
    for (const double yaw : {-0.9, 0.3, 1.2}) {
        const Pose2 truth{6.0, 5.75, yaw};
        for (const double hidden : {0.0, 0.35}) {
            const PlaceSearch::Result found = find(truth, {6.25, 5.65, yaw + 0.6}, hidden);
            ASSERT_TRUE(found.fit.determined) << yaw << " " << hidden;
            const Eigen::Vector3d error = pose_difference(truth, found.fit.pose, shape_);
            EXPECT_LT(error.head<2>().norm(), 0.05) << yaw << " " << hidden;
            EXPECT_LT(error.dot(found.fit.covariance.inverse() * error), 20) << yaw << " " << hidden;
        }
    }
}

TEST_F(HalfHiddenRobot, TheLessIsSeenTheLessIsSure) {
    const Pose2 truth{6.0, 5.75, 0.3};
    const auto area = [&](double hidden) { return find(truth, truth, hidden).fit.covariance.topLeftCorner<2, 2>().determinant(); };
    EXPECT_GT(area(0.6), 2 * area(0));
}

TEST_F(HalfHiddenRobot, AnEmptyAisleHoldsNone) {
    const ForegroundMasks masks{&foreground_.mask, &foreground_.shadow};
    show({});
    Component all;
    all.right = frame_.width() - 1;
    all.bottom = frame_.height() - 1;
    all.centroid = {320, 240};
    const PlaceSearch::Result found =
        search_.find({frame_, &background_, &foreground_, &foreground_.mask}, masks, view_, shape_, measure_blob(masks, all), {6, 5.75, 0}, {}, {});
    EXPECT_TRUE(!found.fit.determined || found.fit.edges < 0);
}

}  // namespace
}  // namespace roomfix
