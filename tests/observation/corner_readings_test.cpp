#include <gtest/gtest.h>

#include "roomfix/observation/corner_observation.hpp"

namespace roomfix {
namespace {

/// What was read beside a moulding's edge on one wall.
CornerObservation beside_an_edge() {
    CornerObservation seen;
    seen.view.place = {1.2, 0.8};
    seen.covariance = 1e-6 * Matrix5d::Identity();
    seen.part = MouldingEdge::lower;
    seen.other_rise = 0.04;
    seen.one_wall_turn = 0.04 * 0.04;
    return seen;
}

TEST(CornerReadings, WhereNothingIsStatedAnEdgeBesideMakesItUncertain) {
    const auto readings = readings_of(beside_an_edge(), std::nullopt, 2.2);
    ASSERT_EQ(readings.size(), 1U);
    EXPECT_GT(readings[0].seen.covariance(0, 0), 1e-3);
    EXPECT_GT(readings[0].seen.covariance(3, 3), 1e-3);
}

TEST(CornerReadings, WhereNoMouldingIsStatedEdgesBesideSayNothing) {
    CornerObservation seen = beside_an_edge();
    const auto readings = readings_of(seen, 0.0, 2.2);
    ASSERT_EQ(readings.size(), 1U);
    EXPECT_TRUE(readings[0].seen.covariance.isApprox(seen.covariance));
    EXPECT_EQ(readings[0].depth, 0);
    seen.read = false;
    EXPECT_EQ(readings_of(seen, 0.0, 2.2).size(), 0U) << "the other corner of a moulding that is not there";
}

TEST(CornerReadings, AStatedMouldingTellsWhichOfTheTwoWasRead) {
    const auto readings = readings_of(beside_an_edge(), 0.085, 2.2);
    ASSERT_EQ(readings.size(), 1U);
    EXPECT_EQ(readings[0].depth, 0.085);
}

}  // namespace
}  // namespace roomfix
