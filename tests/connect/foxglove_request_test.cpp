#include "roomfix/connect/foxglove_request.hpp"

#include <gtest/gtest.h>

namespace roomfix {
namespace {

TEST(FoxgloveRequest, TakesWhatIsRightAndTellsWhatIsNot) {
    const auto request = parse_foxglove_request(
        R"({"op": "subscribe", "subscriptions": [{"id": 5, "channelId": 2}, {"id": 6, "channelId": 4}, {"id": -1, "channelId": 1}, {"id": 4294967296, "channelId": 1}, 7]})",
        3);
    ASSERT_EQ(request.subscribe.size(), 1U);
    EXPECT_EQ(request.subscribe[0].id, 5U);
    EXPECT_EQ(request.subscribe[0].channel, 2U);
    EXPECT_TRUE(request.unsubscribe.empty());
    ASSERT_EQ(request.problems.size(), 4U);
    EXPECT_EQ(request.problems[0], "there is no channel 4");
    for (std::size_t i = 1; i < 4; ++i) EXPECT_EQ(request.problems[i], "a subscription has an id and a channelId");
}

TEST(FoxgloveRequest, EndsSubscriptions) {
    const auto request = parse_foxglove_request(R"({"op": "unsubscribe", "subscriptionIds": [5, "6", 7]})", 3);
    EXPECT_EQ(request.unsubscribe, (std::vector<std::uint32_t>{5, 7}));
    EXPECT_TRUE(request.problems.empty());
}

TEST(FoxgloveRequest, AnythingElseIsAProblem) {
    for (const char* text : {"", "[]", "{", "{\"op\": 1}", "\xff", "{\"op\": \"\xff\"}", R"({"op": "fetchAsset"})"}) {
        const auto request = parse_foxglove_request(text, 3);
        EXPECT_EQ(request.problems.size(), 1U) << text;
        EXPECT_TRUE(request.subscribe.empty() && request.unsubscribe.empty());
    }
    for (const char* text : {R"({"op": "subscribe"})", R"({"op": "subscribe", "subscriptions": 3})", R"({"op": "unsubscribe", "subscriptionIds": {}})"}) {
        const auto request = parse_foxglove_request(text, 3);
        EXPECT_TRUE(request.problems.empty() && request.subscribe.empty() && request.unsubscribe.empty()) << text;
    }
}

}  // namespace
}  // namespace roomfix
