#include "roomfix/smooth/trajectory.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "roomfix/base/decompositions.hpp"
#include "roomfix/base/random.hpp"
#include "roomfix/smooth/knot_covariance.hpp"
#include "roomfix/smooth/residual_series.hpp"
#include "roomfix/smooth/slices.hpp"

namespace roomfix {
namespace {

Fix fix_at(double time, double x, double y, double yaw) {
    Fix fix;
    fix.time = from_seconds(time);
    fix.status = FixStatus::ok;
    fix.pose = {x, y, wrap_angle(yaw)};
    return fix;
}

TEST(Trajectory, PiecesBetweenKnotsAreExactForCubics) {
    const auto cubic = [](double t) { return 1 + 2 * t - 3 * t * t + 0.5 * t * t * t; };
    const auto slope = [](double t) { return 2 - 6 * t + 1.5 * t * t; };
    Trajectory way;
    for (const double t : {1.0, 1.3, 2.0}) {
        way.times.push_back(from_seconds(t));
        way.knots.push_back(Knot::Zero());
        way.knots.back().head<3>().setConstant(cubic(t));
        way.knots.back().tail<3>().setConstant(slope(t));
    }
    for (const double t : {1.0, 1.1, 1.29, 1.3, 1.77, 2.0}) {
        const Knot at = way.at(from_seconds(t));
        for (int i = 0; i < 3; ++i) {
            EXPECT_NEAR(at[i], cubic(t), 1e-9);
            EXPECT_NEAR(at[3 + i], slope(t), 1e-8);
        }
    }
}

TEST(Trajectory, KnotsStandWhereSomethingWasMeasuredAndNeverFarApart) {
    const Nanoseconds ms = 1'000'000;
    const auto times = knot_times({500 * ms, 0, 3 * ms, 20 * ms, 503 * ms}, 100 * ms, 10 * ms);
    ASSERT_EQ(times.front(), 0);
    EXPECT_EQ(times.back(), 503 * ms) << "the end counts although it is close to its neighbour";
    EXPECT_NE(std::find(times.begin(), times.end(), 20 * ms), times.end());
    EXPECT_EQ(std::find(times.begin(), times.end(), 3 * ms), times.end());
    for (std::size_t i = 1; i < times.size(); ++i) {
        EXPECT_GT(times[i], times[i - 1]);
        EXPECT_LE(times[i] - times[i - 1], 100 * ms);
    }
    EXPECT_TRUE(knot_times({}, 100 * ms, 10 * ms).empty());
}

/// The tracker had the robot the wrong way round at first; afterwards it is known better.
TEST(Trajectory, StartsWithTheFrontThatTheTrackerEndedWith) {
    std::vector<Fix> fixes;
    std::vector<Nanoseconds> moments;
    for (int i = 0; i <= 40; ++i) {
        const double t = 0.05 * i;
        const double yaw = 3.0 + 0.5 * t;  // past half a turn
        fixes.push_back(fix_at(t, t, 0, i < 20 ? yaw + std::numbers::pi : yaw));
        moments.push_back(fixes.back().time);
    }
    const auto way = first_trajectory(fixes, knot_times(moments, from_seconds(0.1), from_seconds(0.01)), OdometryTrack(), 2);
    ASSERT_TRUE(way);
    for (std::size_t k = 0; k < way->knots.size(); ++k) {
        EXPECT_NEAR(std::remainder(way->knots[k][2] - (3.0 + 0.5 * to_seconds(way->times[k])), 2 * std::numbers::pi), 0, 1e-9);
        EXPECT_LT(k == 0 ? 0 : std::abs(way->knots[k][2] - way->knots[k - 1][2]), 0.1);
    }
}

TEST(Trajectory, WheelsFillWhatTheTrackerDidNotKnow) {
    OdometryTrack driven;
    std::vector<Fix> fixes;
    std::vector<Nanoseconds> moments;
    const auto truth = [](double t) { return Eigen::Vector2d(2 * std::sin(0.5 * t), 2 - 2 * std::cos(0.5 * t)); };
    for (int i = 0; i <= 80; ++i) {
        const double t = 0.05 * i;
        driven.add(from_seconds(t), {truth(t).x() + 7, truth(t).y() - 3, 0.5 * t});
        moments.push_back(from_seconds(t));
        if (t < 1 || t > 3) fixes.push_back(fix_at(t, truth(t).x(), truth(t).y(), 0.5 * t));
    }
    const auto way = first_trajectory(fixes, knot_times(moments, from_seconds(0.1), from_seconds(0.01)), driven, 1);
    ASSERT_TRUE(way);
    EXPECT_LT((way->at(from_seconds(2)).head<2>() - truth(2)).norm(), 0.01);
    EXPECT_FALSE(first_trajectory({fixes.front()}, moments, driven, 1)) << "one fix is no way";
}

TEST(Trajectory, APartHoldsTheTimesAskedFor) {
    Trajectory way;
    for (int i = 0; i < 10; ++i) {
        way.times.push_back(from_seconds(i));
        way.knots.push_back(Knot::Constant(i));
    }
    const Trajectory part = way.part(from_seconds(2.5), from_seconds(4.5));
    EXPECT_EQ(part.start(), from_seconds(2));
    EXPECT_EQ(part.end(), from_seconds(5));
    const Trajectory all = way.part(from_seconds(-5), from_seconds(50));
    EXPECT_EQ(all.knots.size(), way.knots.size());
}

TEST(WayAlong, IsThatOfTheSecondsAndNotOfTheTrembling) {
    Trajectory way;
    Random random(5);
    for (int i = 0; i <= 1000; ++i) {
        way.times.push_back(from_seconds(0.01 * i));
        way.knots.emplace_back(Knot::Zero());
        way.knots.back().head<3>() << 0.2 * 0.01 * i, 0.005 * random.normal(), 0;
    }
    const std::vector<double> along = way_along(way);
    ASSERT_EQ(along.size(), way.knots.size());
    EXPECT_EQ(along.front(), 0);
    EXPECT_NEAR(along.back(), 2, 0.02);
    EXPECT_NEAR(along[500], 1, 0.02);
    EXPECT_TRUE(std::is_sorted(along.begin(), along.end()));
}

TEST(Slices, EndWhereAnErrorHasBecomeAnother) {
    Trajectory way;  // stands for 10 s, then drives 1 m/s
    for (int i = 0; i <= 200; ++i) {
        way.times.push_back(from_seconds(0.1 * i));
        way.knots.emplace_back(Knot::Zero());
        way.knots.back().x() = std::max(0.1 * i - 10, 0.0);
    }
    const ChangeRate rate{0, 0.5};
    const Slices slices(way, rate);
    for (std::size_t s = 0; s + 1 < slices.size(); ++s) {
        const std::size_t last = slices.first_knot(s + 1) - 1;
        EXPECT_LE((way.knots[last].x() - way.knots[slices.first_knot(s)].x()) * rate.per_metre, part_of_memory + 1e-9);
        EXPECT_LT(last - slices.first_knot(s), 8U) << "more unknowns make the covariance dear";
        EXPECT_EQ(slices.at(way.times[last]), s);
        EXPECT_EQ(slices.at(way.times[last] + 1), s);
    }
    EXPECT_EQ(slices.age(slices.at(0), slices.at(from_seconds(9)), rate), 0) << "it stood";
    EXPECT_NEAR(slices.age(slices.at(from_seconds(10)), slices.size() - 1, rate), 5, 0.3);
    EXPECT_EQ(slices.at(from_seconds(-1)), 0U);
    EXPECT_EQ(slices.at(from_seconds(99)), slices.size() - 1);
    EXPECT_EQ(Slices(way, {}).size(), way.knots.size()) << "nothing changes: each knot for itself";
}

/// A chain of knots, so many in each slice, with so many further unknowns in each slice and common to all.
void expect_inverse(int knots, int in_slice, int further, int common) {
    Random random(3);
    UnknownColumns columns;
    Eigen::Index column = 0;
    std::vector<Eigen::Index> starts;
    for (int k = 0; k < knots; k += in_slice) {
        starts.push_back(column);
        for (int i = k; i < std::min(k + in_slice, knots); ++i) {
            columns.knots.push_back(column);
            column += 6;
        }
        column += further;
        columns.slices.push_back(column - starts.back());
    }
    starts.push_back(column);
    Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(0, column + common);
    const auto add = [&](Eigen::Index from, Eigen::Index to, Eigen::Index rows) {
        const Eigen::Index above = dense.rows();
        dense.conservativeResize(above + rows, Eigen::NoChange);
        dense.bottomRows(rows).setZero();
        for (Eigen::Index r = above; r < above + rows; ++r) {
            for (Eigen::Index c = from; c < to; ++c) dense(r, c) = random.normal();
            for (Eigen::Index c = column; c < column + common; ++c) dense(r, c) = random.normal();
        }
    };
    for (std::size_t s = 0; s + 1 < starts.size(); ++s) add(starts[s], starts[std::min(s + 2, starts.size() - 1)], 3 * columns.slices[s]);
    const Eigen::MatrixXd expected = (dense.transpose() * dense).inverse();
    const SmoothedCovariance covariance = smoothed_covariance(dense.sparseView(), columns);
    ASSERT_EQ(covariance.pairs.size(), static_cast<std::size_t>(knots - 1));
    for (std::size_t k = 0; k < covariance.pairs.size(); ++k) {
        const Eigen::Index a = columns.knots[k], b = columns.knots[k + 1];
        PairCovariance block;
        block << expected.block<6, 6>(a, a), expected.block<6, 6>(a, b), expected.block<6, 6>(b, a), expected.block<6, 6>(b, b);
        EXPECT_LT((covariance.pairs[k] - block).norm(), 1e-8 * block.norm());
    }
    if (common > 0) EXPECT_LT((covariance.common - expected.bottomRightCorner(common, common)).norm(), 1e-8 * covariance.common.norm());
}

TEST(KnotCovariance, IsTheInverseOfTheInformation) {
    for (const int common : {0, 4}) {
        expect_inverse(7, 1, 0, common);
        expect_inverse(8, 3, 5, common);
    }
}

TEST(KnotCovariance, IsEmptyWhereNothingHoldsAKnot) {
    Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(6, 12);
    dense.leftCols(6).setIdentity();
    EXPECT_TRUE(smoothed_covariance(dense.sparseView(), {{6, 6}, {0, 6}}).pairs.empty());
}

/// An average over a first-order autoregressive noise with correlation 0.8 is as uncertain as one over white noise of (1 + 0.8) / (1 - 0.8)
/// times the variance.
TEST(VarianceFactor, CountsVarianceAndCorrelationInTime) {
    for (const double keep : {0.0, 0.8}) {
        Random random(7);
        ResidualSeries series;
        std::vector<double> value = {0, 0};
        for (int i = 0; i < 20000; ++i) {
            for (double& v : value) v = keep * v + std::sqrt(1 - keep * keep) * 1.5 * random.normal();
            series.add(from_seconds(0.04 * i), value);
        }
        const double expected = 2.25 * (1 + keep) / (1 - keep);
        EXPECT_NEAR(variance_factor({&series}), expected, 0.15 * expected);
    }
    ResidualSeries few;
    few.add(0, {100, 100});
    EXPECT_EQ(variance_factor({&few}), 1) << "too few to tell";
    ResidualSeries small;
    for (int i = 0; i < 100; ++i) small.add(from_seconds(i), {0.01});
    EXPECT_EQ(variance_factor({&small}), 1) << "stated noise is never made smaller";
}

}  // namespace
}  // namespace roomfix
