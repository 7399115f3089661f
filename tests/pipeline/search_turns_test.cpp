#include "roomfix/pipeline/search_turns.hpp"

#include <gtest/gtest.h>

namespace roomfix {
namespace {

TEST(SearchTurns, TheFirstFrameAndFramesFarApartSearchForEverything) {
    SearchTurns turns;
    for (int second = 10; second < 14; ++second) {
        Expectation expected;
        turns.set(from_seconds(second), false, expected);
        EXPECT_TRUE(expected.search && expected.search_outlines) << second;
    }
}

TEST(SearchTurns, AtTheUsualRateSearchesComeOneAtATimeAndNoneIsForgotten) {
    SearchTurns turns;
    int bodies = 0, outlines = 0, both = 0;
    for (int i = 0; i < 100; ++i) {
        Expectation expected;
        turns.set(from_seconds(10 + 0.1 * i), false, expected);
        bodies += expected.search;
        outlines += expected.search_outlines;
        both += expected.search && expected.search_outlines;
    }
    EXPECT_NEAR(bodies, 33, 2);
    EXPECT_NEAR(outlines, 33, 2);
    EXPECT_EQ(both, 1) << "the first frame";
}

TEST(SearchTurns, OneCameraWaitsForAnother) {
    SearchTurns turns;
    Expectation expected;
    for (int i = 0; i < 10; ++i) turns.set(from_seconds(10 + 0.1 * i), true, expected);
    EXPECT_FALSE(expected.search_outlines);
    turns.set(from_seconds(11.0), false, expected);
    EXPECT_TRUE(expected.search_outlines);
}

}  // namespace
}  // namespace roomfix
