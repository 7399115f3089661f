#include "roomfix/base/repeat_filter.hpp"

#include <gtest/gtest.h>

namespace roomfix {
namespace {

TEST(RepeatFilter, TellsAFewOfTheSameAndCountsTheRest) {
    RepeatFilter filter(2, 10);
    EXPECT_EQ(filter.pass("the disk is full", 0), "the disk is full");
    EXPECT_EQ(filter.pass("the disk is full", 1), "the disk is full");
    EXPECT_EQ(filter.pass("the disk is full", 2), std::nullopt);
    EXPECT_EQ(filter.pass("a camera is away", 2), "a camera is away");
    EXPECT_EQ(filter.pass("the disk is full", 9), std::nullopt);
    EXPECT_EQ(filter.pass("the disk is full", 10), "the disk is full (and 2 times more before)");
    EXPECT_EQ(filter.pass("the disk is full", 11), "the disk is full");
    EXPECT_TRUE(filter.rest().empty());
    EXPECT_EQ(filter.pass("the disk is full", 12), std::nullopt);
    EXPECT_EQ(filter.rest(), std::vector<std::string>{"the disk is full (1 times more)"});
    EXPECT_TRUE(filter.rest().empty());
}

TEST(RepeatFilter, KeepsNoMoreMessagesThanThereIsRoomFor) {
    RepeatFilter filter(1, 10);
    for (int i = 0; i < 5000; ++i) EXPECT_TRUE(filter.pass("message " + std::to_string(i), 0));
    EXPECT_EQ(filter.pass("message 1", 1), std::nullopt);       // kept
    EXPECT_EQ(filter.pass("message 4999", 1), "message 4999");  // there was no room for it
    EXPECT_EQ(filter.pass("message 4999", 20), "message 4999");
    EXPECT_EQ(filter.pass("message 4999", 21), std::nullopt);  // now there is
}

}  // namespace
}  // namespace roomfix
