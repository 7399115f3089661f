#include "roomfix/overhead/unseen_side.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "overhead/first_aisle.hpp"
#include "roomfix/base/decompositions.hpp"
#include "roomfix/base/random.hpp"

namespace roomfix {
namespace {

/// A box in the first aisle of the li2014 scenario, of which something hides a part that looks as the empty room behind it.
class UnseenSideOfBox : public FirstAisle {
protected:
    UnseenSideOfBox() : FirstAisle(41, 6) { renderer_.render({}, 1, 77, empty_); }

    /// Shows the box, but nothing of it to one side of a column.
    void show_cut(const Pose2& truth, bool left, double cut) {
        show(robot_solids(box, scenario_.robots[0].look, truth));
        for (int y = 0; y < frame_.view().height; ++y) {
            for (int x = 0; x < frame_.view().width; ++x) {
                if (left ? x < cut : x > cut) frame_.row(y)[x] = empty_.row(y)[x];
            }
        }
        background_.classify_solid(frame_, foreground_);
    }
    /// Shows it but for a `share` of its width at one side.
    void show_hidden(const Pose2& truth, bool left, double share) {
        const PixelBox seen = box_around(project_silhouette(view_, shape_, truth).polygon());
        show_cut(truth, left, seen.low.x() + (left ? share : 1 - share) * (seen.high.x() - seen.low.x()));
    }
    /// Half of the squares of the errors over what is stated, of the place.
    static double square(const OutlineFit& fit, const Pose2& truth) {
        const Eigen::Vector2d off(fit.pose.x - truth.x, fit.pose.y - truth.y);
        return 0.5 * off.dot(fit.covariance.topLeftCorner<2, 2>().inverse() * off);
    }

    static constexpr Box box{0.54, 0.50, 0.45};
    const ShapePoints shape_ = shape_points(box, 0.003);
    LumaImage empty_;
};

TEST_F(UnseenSideOfBox, IsNotTakenForTheBorderOfWhatHidesIt) {
    Random random(3);
    double squares = 0, before = 0;
    int count = 0, wrong = 0, wrong_before = 0;
    for (const bool left : {true, false}) {
        for (const double share : {0.03, 0.06, 0.1, 0.3}) {
            for (int i = 0; i < 8; ++i) {
                const Pose2 truth{5.8 + 0.1 * (i % 4), 5.6 + 0.05 * (i % 3), 0.2 * i};
                show_hidden(truth, left, share);
                PoseObservation expected;
                expected.pose = {truth.x + random.normal(0.015), truth.y + random.normal(0.015), truth.yaw + random.normal(0.01)};
                expected.covariance = Eigen::Vector3d(2.25e-4, 2.25e-4, 1e-4).asDiagonal();
                const FrameEvidence evidence{frame_, &background_, &foreground_, &foreground_.mask};
                const OutlineFit whole = fit_outline(evidence, view_, shape_, expected.pose, {});
                if (!whole.determined) continue;
                const OutlineFit weighed = weigh_unseen_sides(evidence, view_, {&shape_, 1}, whole, {}, &expected, {});
                squares += std::min(square(weighed, truth), 100.0);
                before += std::min(square(whole, truth), 100.0);
                wrong += square(weighed, truth) > 12;
                wrong_before += square(whole, truth) > 12;
                ++count;
            }
        }
    }
    std::printf("%d outlines: squares of the errors %.2f (whole outline alone: %.2f), far off what they say: %d (%d)\n", count, squares / count, before / count,
                wrong, wrong_before);
    EXPECT_GT(count, 48);
    EXPECT_GT(before, 3 * squares);
    EXPECT_LT(squares / count, 1.5);
    EXPECT_LE(wrong, 1);
}

TEST_F(UnseenSideOfBox, WhatAKnownWallHidesIsNotAskedFor) {
    const Eigen::Vector2d camera = view_.position().head<2>();
    double squares = 0;
    int count = 0, hidden = 0;
    for (const bool left : {true, false}) {
        for (const double inside : {0.02, 0.1, 0.2}) {  // m: the wall's edge is seen so far from the box's middle towards its side
            const Pose2 truth{6, 5.7, 0.1};
            const Eigen::Vector2d ahead = (Eigen::Vector2d(truth.x, truth.y) - camera).normalized();
            const Eigen::Vector2d to_left(-ahead.y(), ahead.x());
            const Eigen::Vector2d seen_at = Eigen::Vector2d(truth.x, truth.y) + (left ? inside : -inside) * to_left;
            const Eigen::Vector2d edge = camera + 0.6 * (seen_at - camera);
            const std::vector<Polyline> walls{{edge, edge + (left ? 2.0 : -2.0) * to_left}};
            show_cut(truth, left, project_map_point(view_, {seen_at.x(), seen_at.y(), 0.2})->x());
            const FrameEvidence evidence{frame_, &background_, &foreground_, &foreground_.mask, &walls};
            const FrameEvidence unknown{frame_, &background_, &foreground_, &foreground_.mask};
            const Pose2 start{truth.x + 0.01, truth.y + (left ? -0.015 : 0.015), truth.yaw};
            const OutlineFit fit = fit_outline(evidence, view_, shape_, start, {});
            ASSERT_TRUE(fit.determined);
            hidden += fit.visible < fit_outline(unknown, view_, shape_, start, {}).visible;
            squares += square(fit, truth);
            EXPECT_LT(square(fit, truth), 10) << left << " " << inside;
            ++count;
        }
    }
    EXPECT_EQ(hidden, count);
    EXPECT_LT(squares / count, 2.5);
}

}  // namespace
}  // namespace roomfix
