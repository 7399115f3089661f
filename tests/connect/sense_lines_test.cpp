#include "roomfix/connect/sense_lines.hpp"

#include <gtest/gtest.h>

#include "roomfix/base/random.hpp"
#include "roomfix/connect/udp_port.hpp"
#include "roomfix/site/load_site.hpp"

namespace roomfix {
namespace {

constexpr const char* two_robots =
    "roomfix: 1\n"
    "site: {name: hall}\n"
    "robots:\n"
    "  a: {shape: box, size: [0.5, 0.5, 0.5], odometry: {source: 'udp://127.0.0.1:5005'}, receiver: {position: [0, 0, 0.2], source: 'udp://127.0.0.1:5005'}}\n"
    "  b: {shape: box, size: [0.5, 0.5, 0.5], odometry: {source: 'udp://127.0.0.1:5005'}}\n"
    "beacons: {n: {position: [0, 0, 2]}}\n"
    "landmarks: {post: {position: [1, 2, 0]}}\n";

TEST(SenseLines, TellsReadingsApartAndKnowsWhoseTheyAre) {
    const Site site = parse_site(two_robots, "/somewhere").site;
    ASSERT_EQ(site.robots.size(), 2U);
    SenseLines lines(site, "udp://127.0.0.1:5005");
    const Nanoseconds now = from_seconds(1000);
    const Readings readings = lines.read(
        "{\"time\": 999.99, \"robot\": \"b\", \"x\": 1, \"y\": 2, \"yaw\": 0.5}\n"
        "{\"beacon\": \"n\", \"range\": 2.5}\n"
        "\r\n"
        "{\"time\": 999.99, \"robot\": \"a\", \"landmark\": \"post\", \"bearing\": -0.25}\n"
        "{\"x\": 1, \"y\": 2, \"yaw\": 0.5}\n"
        "nonsense\n"
        "[1, 2]",
        now, 10);
    ASSERT_EQ(readings.odometry.poses.size(), 1U);
    EXPECT_EQ(readings.odometry.poses[0].robot, 1);
    EXPECT_EQ(readings.odometry.poses[0].time, from_seconds(999.99));
    ASSERT_EQ(readings.ranges.ranges.size(), 1U);  // only one robot has a receiver there
    EXPECT_EQ(readings.ranges.ranges[0].robot, 0);
    EXPECT_EQ(readings.ranges.ranges[0].time, now);
    ASSERT_EQ(readings.sightings.sightings.size(), 1U);
    EXPECT_EQ(readings.sightings.sightings[0].bearing, -0.25);
    EXPECT_EQ(readings.odometry.problems.size(), 1U);  // whose wheels?
    EXPECT_EQ(readings.ranges.problems.size(), 2U);
}

TEST(SenseLines, ALineThatIsTooLongCostsItselfOnly) {
    const Site site = parse_site(two_robots, "/somewhere").site;
    SenseLines lines(site, "udp://127.0.0.1:5005");
    const Readings readings = lines.read("{\"robot\": \"" + std::string(100000, 'x') + "\"}\n{\"robot\": \"a\", \"beacon\": \"n\", \"range\": 2}\n", 1000, 10);
    EXPECT_EQ(readings.ranges.ranges.size(), 1U);
    EXPECT_EQ(readings.ranges.problems.size(), 1U);
}

TEST(SenderClock, OneThatAgreesIsBelieved) {
    Random random(3);
    SenderClock clock;
    for (int i = 0; i < 300; ++i) {
        const Nanoseconds taken = from_seconds(5000 + 0.1 * i);
        const Nanoseconds arrived = taken + from_seconds(0.002 + 0.03 * random.uniform(0, 1));
        EXPECT_EQ(clock.ours(taken, arrived, 0.1 * i), taken);
    }
    EXPECT_NE(clock.told().find("agrees"), std::string::npos);
}

TEST(SenderClock, ReadingsThatQueueUpAreNoClockThatWasSet) {
    SenderClock clock;
    const Nanoseconds start = from_seconds(1000);
    double delay = 0.004;
    for (int i = 0; i < 440; ++i) {  // up to 9 s late and back again
        if (i >= 40) delay = std::max(0.004, i < 240 ? delay + 0.045 : delay - 0.05);
        const double taken = 0.05 * i;
        const Nanoseconds stamp = start + from_seconds(taken);
        EXPECT_EQ(clock.ours(stamp, stamp + from_seconds(delay), taken + delay), stamp) << i;
    }
}

TEST(SenderClock, OneThatIsSetIsFollowedAtOnce) {
    SenderClock clock;
    double ahead = 0;
    for (int i = 0; i < 600; ++i) {
        if (i == 200) ahead = 3600;
        if (i == 400) ahead = -3600;
        const double taken = 1000 + 0.05 * i;
        const Nanoseconds ours = clock.ours(from_seconds(taken + ahead), from_seconds(taken + 0.004), taken + 0.004);
        EXPECT_NEAR(to_seconds(ours), taken, 0.0045) << i;
    }
}

TEST(SenderClock, WhatStaysLateIsAnotherClock) {
    SenderClock clock;
    double off = 0;
    for (int i = 0; i < 2000; ++i) {  // it was set back while nothing came
        const double taken = 1000 + 0.05 * i + (i < 200 ? 0 : 30), behind = i < 200 ? 0 : 20;
        off = to_seconds(clock.ours(from_seconds(taken - behind), from_seconds(taken + 0.004), taken + 0.004)) - taken;
    }
    EXPECT_NEAR(off, 0, 0.0045);
}

TEST(SenderClock, OneThatDiffersAndDriftsIsFollowed) {
    Random random(4);
    SenderClock clock;
    double worst = 0;
    for (int i = 0; i < 1200; ++i) {
        const double ours = 5000 + 0.1 * i;
        const double theirs = 12.5 + 0.1 * i * (1 + 100e-6);  // seconds since it was switched on; 100 ppm fast
        const double arrived = ours + 0.003 + 0.02 * random.uniform(0, 1);
        const Nanoseconds moved = clock.ours(from_seconds(theirs), from_seconds(arrived), ours);
        if (i > 200) worst = std::max(worst, std::abs(to_seconds(moved) - ours));
    }
    EXPECT_LT(worst, 0.006);  // the least delay, 3 ms, cannot be known
    EXPECT_NE(clock.told().find("behind"), std::string::npos);
    const std::string told = clock.told();
    const std::size_t drift = told.find("drifts by ");
    ASSERT_NE(drift, std::string::npos) << told;
    EXPECT_NEAR(std::stoi(told.substr(drift + 10)), -100, 15) << told;  // 20 ms of jitter over a minute
}

TEST(UdpPort, SaysWhyItCannotListen) {
    EXPECT_NE(UdpPort::open("udp://0.0.0.0:5005").error().message.find("?insecure"), std::string::npos);
    EXPECT_FALSE(UdpPort::open("udp://127.0.0.1"));
    EXPECT_FALSE(UdpPort::open("udp://127.0.0.1:99999"));
    EXPECT_FALSE(UdpPort::open("udp://no.such.host.invalid:5005?insecure"));
    auto first = UdpPort::open("udp://127.0.0.1:45871");
    ASSERT_TRUE(first) << first.error().message;
    EXPECT_NE(UdpPort::open("udp://127.0.0.1:45871").error().message.find("another program"), std::string::npos);
}

}  // namespace
}  // namespace roomfix
