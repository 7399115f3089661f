#include "roomfix/connect/range_source.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <stdlib.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

namespace roomfix {
namespace {

Site small_site() {
    Site site;
    site.robots.resize(1);
    site.robots[0].id = "r1";
    site.robots[0].receivers = {Receiver{}};
    site.beacons = {{"ship", {0, 0, 3}, ""}};
    return site;
}

TEST(RangeSource, AFileIsReadInTheOrderOfItsTimes) {
    const auto file = (std::filesystem::temp_directory_path() / "roomfix_ranges.csv").string();
    std::ofstream(file) << "time,robot,beacon,range\n2.0,r1,ship,3.1\n1.5,r1,ship,3.0\n1.7,r1,boat,3.0\n";
    const auto batch = load_ranges(file, small_site(), 0);
    ASSERT_TRUE(batch) << batch.error().message;
    ASSERT_EQ(batch->ranges.size(), 2U);
    EXPECT_LT(batch->ranges[0].time, batch->ranges[1].time);
    ASSERT_EQ(batch->problems.size(), 1U);
    EXPECT_NE(batch->problems[0].find("boat"), std::string::npos);
    std::ofstream(file) << "nothing of use\nat all\n";
    EXPECT_FALSE(load_ranges(file, small_site(), 0));
    EXPECT_FALSE(load_ranges("/nowhere.csv", small_site(), 0));
    EXPECT_FALSE(load_ranges(std::filesystem::temp_directory_path().string(), small_site(), 0));
}

TEST(RangeSource, ASerialListenerIsHeardThroughATerminal) {
    const int other_end = ::posix_openpt(O_RDWR | O_NOCTTY);
    if (other_end < 0 || ::grantpt(other_end) != 0 || ::unlockpt(other_end) != 0) GTEST_SKIP() << "no pseudo terminals here";
    auto line = SerialLine::open(::ptsname(other_end));
    ASSERT_TRUE(line) << line.error().message;
    const std::string sent = "VR=2.0,SP=ship,DB=254,DR=7400,TM=7760,TS=100\r\nVR=2.0,SP=sh";
    ASSERT_EQ(::write(other_end, sent.data(), sent.size()), static_cast<ssize_t>(sent.size()));
    const Site site = small_site();
    RangeReader reader(site, 0);
    RangeBatch batch;
    std::string bytes;
    for (int i = 0; i < 20 && bytes.size() < sent.size(); ++i) ASSERT_TRUE(line->read(0.1, bytes));
    EXPECT_EQ(bytes, sent) << "a raw line: no echo, no translation of line ends";
    reader.feed(bytes, 7, batch);
    ASSERT_EQ(batch.ranges.size(), 1U);
    EXPECT_NEAR(batch.ranges[0].range, 2.54, 0.01);
    ::close(other_end);
    bytes.clear();
    bool there = true;
    for (int i = 0; i < 20 && there; ++i) there = line->read(0.05, bytes);
    EXPECT_FALSE(there) << "a listener that was pulled out is noticed";
    EXPECT_FALSE(SerialLine::open("/dev/no-such-listener"));
}

}  // namespace
}  // namespace roomfix
