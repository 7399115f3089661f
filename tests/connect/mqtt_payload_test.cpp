#include "roomfix/connect/mqtt_payload.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "roomfix/connect/iso_time.hpp"

namespace roomfix {
namespace {

TEST(IsoTime, CountsLeapDaysAndCutsToMilliseconds) {
    EXPECT_EQ(iso_time(0), "1970-01-01T00:00:00.000Z");
    EXPECT_EQ(iso_time(951782400123999999), "2000-02-29T00:00:00.123Z");
    EXPECT_EQ(iso_time(-1), "1969-12-31T23:59:59.999Z");
}

TEST(MqttPayload, APoseIsJsonOfFiniteNumbers) {
    Fix fix;
    fix.time = 1500000000;
    fix.robot = "r1";
    fix.status = FixStatus::ok;
    fix.pose = {1.23456789, -2, 0.5};
    fix.covariance << 0.04, 0, 0, 0, 0.01, 0, 0, 0, 0.02;
    fix.sources = {"hall \"2\""};
    const auto json = nlohmann::json::parse(pose_payload(fix));
    EXPECT_EQ(json["t"], "1970-01-01T00:00:01.500Z");
    EXPECT_DOUBLE_EQ(json["x"].get<double>(), 1.234568);
    EXPECT_DOUBLE_EQ(json["sigma"].get<double>(), 0.2);
    EXPECT_EQ(json["cov"].size(), 6U);
    EXPECT_EQ(json["src"][0], "hall \"2\"");
    fix.yaw_known = false;
    EXPECT_TRUE(nlohmann::json::parse(pose_payload(fix))["yaw"].is_null());
}

TEST(MqttPayload, NamesCannotReachOtherTopics) {
    EXPECT_EQ(topic_word("cart-1"), "cart-1");
    EXPECT_EQ(topic_word("a/b+#$ ü"), "a_b______");
    EXPECT_EQ(topic_word(""), "_");
}

}  // namespace
}  // namespace roomfix
