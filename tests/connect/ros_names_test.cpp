#include "roomfix/connect/ros_names.hpp"

#include <gtest/gtest.h>

namespace roomfix {
namespace {

TEST(RosNames, AreWordsOfRos) {
    RosNames names;
    EXPECT_EQ(names.of("r1"), "r1");
    EXPECT_EQ(names.of("cart-12"), "cart_12");
    EXPECT_EQ(names.of("7up"), "id_7up");
    EXPECT_EQ(names.of("a--b__c-"), "a_b_c");  // no two underscores in a row, and none at the end
    EXPECT_EQ(names.of("-"), "id");
}

TEST(RosNames, NoTwoIdsGetTheSameWord) {
    RosNames names;
    EXPECT_EQ(names.of("a-b"), "a_b");
    EXPECT_EQ(names.of("a_b"), "a_b_2");
    EXPECT_EQ(names.of("a-b-2"), "a_b_2_2");
    EXPECT_EQ(names.of("a-b"), "a_b");  // the same every time
    names.forget("a-b");
    names.forget("never heard of");
    EXPECT_EQ(names.of("a.b"), "a_b");
}

}  // namespace
}  // namespace roomfix
