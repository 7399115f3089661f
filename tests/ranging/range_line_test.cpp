#include "roomfix/ranging/range_line.hpp"

#include <gtest/gtest.h>

#include "roomfix/ranging/flight_time.hpp"
#include "roomfix/ranging/range_reader.hpp"

namespace roomfix {
namespace {

const std::string manual_line = "VR=2.0,ID=01:25:61:61:0b:00:00:42,SP=ship,DB=55,DR=1676,TM=2034,TS=22528";

TEST(FlightTime, SpeedOfSoundAndRange) {
    EXPECT_NEAR(speed_of_sound(0), 331.3, 1e-9);
    EXPECT_NEAR(speed_of_sound(20), 343.2, 0.1);
    EXPECT_NEAR(range_from_delay(0.01, 20), 3.432, 0.001);
    EXPECT_GT(range_from_delay(0.01, 20), 0.01 * speed_of_sound(20)) << "the radio took its time, too";
    EXPECT_NEAR(temperature_sigma(3, 20, 1) / 3, 0.0017, 1e-4) << "1 degC is 0.17 %";
}

TEST(CricketLine, ReadsTheManualsExample) {
    const auto line = parse_cricket_line(manual_line, 20);
    ASSERT_TRUE(line) << line.error().message;
    EXPECT_EQ(line->beacon, "01:25:61:61:0b:00:00:42");
    EXPECT_EQ(line->alias, "ship");
    EXPECT_NEAR(line->value, 0.5752, 1e-3) << "from DR, not from the rounded DB";
    EXPECT_EQ(line->listener_clock, 22528000000);
}

TEST(CricketLine, TakesAnyOrderAndMissingFields) {
    const auto swapped = parse_cricket_line("TS=5,DR=1676,SP=ship,DB=55", 20);
    ASSERT_TRUE(swapped);
    EXPECT_TRUE(swapped->beacon.empty());
    const auto only_db = parse_cricket_line("ID=1:25:61:61:b:0:0:42,DB=254\r", 20);
    ASSERT_TRUE(only_db) << only_db.error().message;
    EXPECT_EQ(only_db->beacon, "01:25:61:61:0b:00:00:42") << "bytes are not always padded";
    EXPECT_NEAR(only_db->value, 2.54, 1e-12);
    EXPECT_FALSE(only_db->flight_time);
}

TEST(CricketLine, RefusesWhatIsNotWhole) {
    for (const char* line : {
             "VR=2.0,ID=01:25:61:61:0b:00:00:42,SP=ship,TM=2034",                               // no distance
             "VR=2.0,DB=55,DR=1676",                                                            // no beacon
             "VR=2.0,ID=01:25:61:61:0b:00:42,DB=55",                                            // seven bytes
             "VR=2.0,ID=01:25:61:61:0b:00:00:42,SP=shVR=2.0,ID=01:25:61:61:0b:00:00:42,DB=55",  // two lines in one
             "VR=2.0,ID=01:25:61:61:0b:00:00:42,SP=ship,DB=55,DR=16",                           // cut off within DR
             "SP=ship,DB=-3",
             "SP=ship,DB=0x20",
             "SP=ship,DB=1e999",
             "5:61:61:0b:00:00:42,SP=ship,DB=55",
             "\xff\xfe,DB=55",
             "",
         }) {
        EXPECT_FALSE(parse_cricket_line(line, 20)) << line;
    }
}

TEST(JsonLine, ReadsRangesAndDifferences) {
    const auto range = parse_json_line(R"({"time": 12.5, "robot": "r1", "beacon": "n1", "range": 2.75, "sigma": 0.01})");
    ASSERT_TRUE(range) << range.error().message;
    EXPECT_EQ(*range->time, 12500000000);
    EXPECT_EQ(range->value, 2.75);
    EXPECT_EQ(range->sigma, 0.01);
    const auto difference = parse_json_line(R"({"time": 1, "beacons": ["a", "b"], "difference": -0.5})");
    ASSERT_TRUE(difference);
    EXPECT_EQ(difference->far_beacon, "b");
    for (const char* line :
         {R"({"time": 1, "beacon": "n1"})", R"({"time": 1, "range": 3})", R"({"beacon": 5, "range": 3})", R"({"beacons": ["a"], "difference": 1})",
          R"({"time": 1e300, "beacon": "n1", "range": 3})", "[1]", "{", R"({"beacon": "n1", "range": "3"})"}) {
        EXPECT_FALSE(parse_json_line(line)) << line;
    }
}

class Reader : public ::testing::Test {
protected:
    Reader() {
        site.robots.resize(2);
        site.robots[0].id = "r1";
        site.robots[1].id = "r2";
        site.robots[0].receivers = {Receiver{}};
        site.beacons = {{"n1", {1, 1.25, 3}, "1:25:61:61:b:0:0:42"}, {"ship", {4, 1.25, 3}, ""}};
    }
    RangeBatch read(const std::string& bytes, std::optional<Nanoseconds> arrival = 5) {
        RangeReader reader(site, 0);
        RangeBatch batch;
        reader.feed(bytes, arrival, batch);
        reader.finish(arrival, batch);
        return batch;
    }
    Site site;
};

TEST_F(Reader, FindsBeaconsByAddressAndBySpaceName) {
    const RangeBatch batch = read(manual_line + "\r\nSP=ship,DB=254\n");
    ASSERT_EQ(batch.ranges.size(), 2U) << (batch.problems.empty() ? "" : batch.problems[0]);
    EXPECT_EQ(batch.ranges[0].beacon, 0);
    EXPECT_EQ(batch.ranges[1].beacon, 1);
    EXPECT_EQ(batch.ranges[0].time, 5);
    EXPECT_GT(batch.ranges[0].sigma, 0.02) << "the air's temperature is not known exactly";
}

TEST_F(Reader, ReadsCsvOfRangesAndOfDifferences) {
    const RangeBatch batch = read("time,robot,beacon,range,sigma\n1.5,r2,n1,2.75,0.01\n1.6,r1,ship,3.1,\n");
    ASSERT_EQ(batch.ranges.size(), 2U);
    EXPECT_EQ(batch.ranges[0].robot, 1);
    EXPECT_EQ(batch.ranges[0].sigma, 0.01);
    EXPECT_EQ(batch.ranges[1].time, 1600000000);
    EXPECT_EQ(batch.ranges[1].sigma, 0.02);
    const RangeBatch pairs = read("time,robot,beacon_a,beacon_b,difference\n1.5,r1,n1,ship,-0.4");
    ASSERT_EQ(pairs.differences.size(), 1U) << pairs.problems[0];
    EXPECT_EQ(pairs.differences[0].difference, -0.4);
}

TEST_F(Reader, ABadLineCostsItselfOnly) {
    const std::string good = "{\"time\": 1, \"beacon\": \"n1\", \"range\": 2.7}\n";
    for (const std::string& bad : {
             std::string("{\"time\": 1, \"beacon\": \"n9\", \"range\": 2.7}"),   // unknown beacon
             std::string("{\"time\": 1, \"beacon\": \"n1\", \"range\": -2.7}"),  // negative
             std::string("{\"time\": 1, \"beacon\": \"n1\", \"range\": 0}"),     // zero
             std::string("{\"time\": 1, \"beacon\": \"n1\", \"range\": 1e7}"),   // absurd
             std::string("{\"time\": 1, \"robot\": \"r7\", \"beacon\": \"n1\", \"range\": 2.7}"),
             std::string("{\"time\": 1, \"beacon\": \"n1\", \"range\": 2.7, \"sigma\": -1}"),
             std::string("VR=2.0,ID=01:25:61:"),  // truncated
             std::string(5000, 'x'),              // oversized
             std::string("\0\x01\xff=\x80", 5),   // garbled
         }) {
        const RangeBatch batch = read(good + bad + "\n" + good);
        EXPECT_EQ(batch.ranges.size(), 2U) << bad.substr(0, 60);
        EXPECT_EQ(batch.problems.size(), 1U) << bad.substr(0, 60);
    }
}

TEST_F(Reader, LinesMayComeInPieces) {
    RangeReader reader(site, 0);
    RangeBatch batch;
    const std::string bytes = manual_line + "\n" + manual_line + "\n";
    for (const char c : bytes) reader.feed(std::string_view(&c, 1), 7, batch);
    EXPECT_EQ(batch.ranges.size(), 2U);
    EXPECT_EQ(reader.lines(), 2);
}

TEST_F(Reader, AClockThatRunsBackwardsIsReportedOnceAndThenBelieved) {
    const auto at = [](int t) { return "{\"time\": " + std::to_string(t) + ", \"beacon\": \"n1\", \"range\": 2.7}\n"; };
    const RangeBatch batch = read(at(100) + at(101) + at(3) + at(4));
    EXPECT_EQ(batch.ranges.size(), 3U);
    ASSERT_EQ(batch.problems.size(), 1U);
    EXPECT_NE(batch.problems[0].find("backwards"), std::string::npos);
}

TEST_F(Reader, WithoutAnyTimeALineIsRefused) {
    EXPECT_EQ(read("SP=ship,DB=254\n", std::nullopt).ranges.size(), 0U);
    const RangeBatch logged = read("SP=ship,DB=254,TS=2500\n", std::nullopt);
    ASSERT_EQ(logged.ranges.size(), 1U);
    EXPECT_EQ(logged.ranges[0].time, 2500000000);
}

}  // namespace
}  // namespace roomfix
