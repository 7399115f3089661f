#include "roomfix/ranging/trilateration.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "roomfix/base/decompositions.hpp"
#include "roomfix/base/random.hpp"

namespace roomfix {
namespace {

const std::vector<Eigen::Vector3d> corners = {{0, 0, 3}, {5, 0, 3}, {5, 4, 2.8}, {0, 4, 3}};
constexpr double height = 0.3;

double distance(const Eigen::Vector3d& beacon, const Eigen::Vector2d& p) { return (beacon - Eigen::Vector3d(p.x(), p.y(), height)).norm(); }

std::vector<BeaconRange> ranges_to(const std::vector<Eigen::Vector3d>& beacons, const Eigen::Vector2d& p, double sigma, Random* random) {
    std::vector<BeaconRange> ranges;
    for (const auto& b : beacons) ranges.push_back({b, distance(b, p) + (random ? random->normal(sigma) : 0), sigma});
    return ranges;
}

TEST(Trilateration, IsExactWithoutNoise) {
    const Eigen::Vector2d p(1.3, 2.2);
    const auto result = trilaterate(ranges_to(corners, p, 0.01, nullptr), {}, height);
    ASSERT_TRUE(result) << result.error().message;
    EXPECT_EQ(result->places.size(), 1U);
    EXPECT_LT((result->places[0].position - p).norm(), 1e-4) << "where late ranges are possible, the likeliest place is a hair beside";
    const auto plain = trilaterate(ranges_to(corners, p, 0.01, nullptr), {}, height, {.robust = false});
    ASSERT_TRUE(plain);
    EXPECT_LT((plain->places[0].position - p).norm(), 1e-7);
}

TEST(Trilateration, EstimatesADelayThatAllRangesShare) {
    Random random(9);
    const Eigen::Vector2d p(1.3, 2.2);
    auto ranges = ranges_to(corners, p, 0.02, &random);
    for (auto& r : ranges) r.range += 0.8;
    const auto with = trilaterate(ranges, {}, height, {.shared_delay = 1});
    ASSERT_TRUE(with) << with.error().message;
    EXPECT_LT((with->places[0].position - p).norm(), 0.2);
    EXPECT_NEAR(with->shared_delay, 0.8, 0.1);
}

TEST(Trilateration, CovarianceIsTrue) {
    // Two unknowns, 400 runs: mean NEES within 2 +- 0.39 has a false-alarm rate of 1e-4.
    Random random(77);
    double sum = 0;
    for (int i = 0; i < 400; ++i) {
        const Eigen::Vector2d p(random.uniform(0.5, 4.5), random.uniform(0.5, 3.5));
        const auto result = trilaterate(ranges_to(corners, p, 0.02, &random), {}, height, {.robust = false});
        ASSERT_TRUE(result);
        const Eigen::Vector2d e = result->places[0].position - p;
        sum += e.dot(result->places[0].covariance.inverse() * e);
    }
    EXPECT_NEAR(sum / 400, 2, 0.39);
}

TEST(Trilateration, ALateRangeIsLeftOutAndPlainLeastSquaresIsPulledAway) {
    Random random(5);
    double robust = 0;
    double plain = 0;
    for (int i = 0; i < 100; ++i) {
        const Eigen::Vector2d p(random.uniform(0.5, 4.5), random.uniform(0.5, 3.5));
        auto ranges = ranges_to(corners, p, 0.02, &random);
        const auto late = static_cast<std::size_t>(random.index(4));
        ranges[late].range += 1.0;
        const auto ours = trilaterate(ranges, {}, height);
        const auto theirs = trilaterate(ranges, {}, height, {.robust = false});
        ASSERT_TRUE(ours && theirs);
        robust += (ours->places[0].position - p).norm();
        plain += (theirs->places[0].position - p).norm();
        if ((ours->places[0].position - p).norm() < 0.15) {
            EXPECT_LT(ours->on_time[late], 0.1);
        }
    }
    EXPECT_LT(robust / 100, 0.12);
    EXPECT_GT(plain, 4 * robust);
}

TEST(Trilateration, TwoRangesGiveBothPlaces) {
    const Eigen::Vector2d p(1.3, 2.2);
    const auto result = trilaterate(ranges_to({corners[0], corners[1]}, p, 0.02, nullptr), {}, height);
    ASSERT_TRUE(result) << result.error().message;
    ASSERT_EQ(result->places.size(), 2U);
    EXPECT_NEAR(result->places[0].weight, 0.5, 0.01);
    EXPECT_NEAR(result->places[0].position.y() + result->places[1].position.y(), 0, 1e-6) << "mirrored at the line of the beacons";
}

TEST(Trilateration, TellsWhenTheGeometryIsDegenerate) {
    EXPECT_FALSE(trilaterate(ranges_to({corners[0]}, {1, 1}, 0.02, nullptr), {}, height));
    EXPECT_FALSE(trilaterate({}, {}, height));
    const auto same_place = trilaterate(ranges_to({corners[0], corners[0], corners[0]}, {1, 1}, 0.02, nullptr), {}, height);
    ASSERT_FALSE(same_place);
    // On the line through the beacons the side distance cannot be seen: either an error, or a covariance that says so.
    const auto line = trilaterate(ranges_to({{0, 0, 0.3}, {2, 0, 0.3}, {4, 0, 0.3}}, {7, 0}, 0.02, nullptr), {}, height);
    if (line) {
        EXPECT_GT(std::sqrt(line->places[0].covariance(1, 1)), 0.2);
    }
}

TEST(Trilateration, RangeDifferencesAloneAndMixed) {
    Random random(3);
    const Eigen::Vector2d p(1.3, 2.2);
    std::vector<BeaconDifference> differences;
    for (std::size_t i = 1; i < corners.size(); ++i) {
        differences.push_back({corners[0], corners[i], distance(corners[i], p) - distance(corners[0], p) + random.normal(0.02), 0.02});
    }
    const auto alone = trilaterate({}, differences, height);
    ASSERT_TRUE(alone) << alone.error().message;
    EXPECT_LT((alone->places[0].position - p).norm(), 0.1);
    const auto one_range = ranges_to({corners[2]}, p, 0.02, &random);
    const auto mixed = trilaterate(one_range, differences, height);
    ASSERT_TRUE(mixed);
    EXPECT_LT(mixed->places[0].covariance.trace(), alone->places[0].covariance.trace());
    EXPECT_LT((mixed->places[0].position - p).norm(), 0.1);
}

}  // namespace
}  // namespace roomfix
