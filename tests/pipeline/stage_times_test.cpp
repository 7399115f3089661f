#include "roomfix/pipeline/stage_times.hpp"

#include <gtest/gtest.h>

namespace roomfix {
namespace {

TEST(StageTimes, QuantilesAreThoseOfWhatWasAdded) {
    StageTimes times;
    for (int i = 1; i <= 1000; ++i) times.add(Stage::look, 1e-3 * i);
    const StageSummary summary = times.summary(Stage::look);
    EXPECT_EQ(summary.count, 1000);
    EXPECT_NEAR(summary.median, 0.5, 0.06);
    EXPECT_NEAR(summary.p95, 0.95, 0.1);
    EXPECT_NEAR(summary.p99, 0.99, 0.1);
    EXPECT_DOUBLE_EQ(summary.largest, 1.0);
    EXPECT_EQ(times.summary(Stage::fit).count, 0);
}

TEST(StageTimes, TheTextNamesTheStagesThatTookTimeAndNoOthers) {
    StageTimes times;
    times.add(Stage::decode, 0.002);
    times.add(Stage::moment, 0.030);
    times.add(Stage::moment, 0.300);
    const std::string text = times.text();
    EXPECT_NE(text.find("decode"), std::string::npos);
    EXPECT_NE(text.find("moment in ms"), std::string::npos) << text;
    EXPECT_EQ(text.find("track"), std::string::npos) << text;
}

TEST(StageTimes, NothingIsTooShortOrTooLong) {
    StageTimes times;
    times.add(Stage::fit, 0);
    times.add(Stage::fit, -1);
    times.add(Stage::fit, 1e9);
    EXPECT_EQ(times.summary(Stage::fit).count, 3);
    EXPECT_DOUBLE_EQ(times.summary(Stage::fit).largest, 1e9);
}

}  // namespace
}  // namespace roomfix
