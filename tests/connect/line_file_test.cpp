// Files that stay whole where the disk is full and where the program is killed.
#include "roomfix/connect/line_file.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <filesystem>

#include "roomfix/base/text_file.hpp"
#include "roomfix/connect/odometry_source.hpp"
#include "roomfix/connect/range_source.hpp"
#include "roomfix/connect/sensed_lines.hpp"
#include "roomfix/connect/sighting_source.hpp"
#include "temporary_folder.hpp"

namespace roomfix {
namespace {

class LineFiles : public TemporaryFolder {};

/// No file may be larger, as if the disk were full.
class SmallDisk {
public:
    explicit SmallDisk(rlim_t bytes) {
        getrlimit(RLIMIT_FSIZE, &before_);
        rlimit small = before_;
        small.rlim_cur = bytes;
        signal_ = std::signal(SIGXFSZ, SIG_IGN);
        setrlimit(RLIMIT_FSIZE, &small);
    }
    ~SmallDisk() {
        setrlimit(RLIMIT_FSIZE, &before_);
        std::signal(SIGXFSZ, signal_);
    }

private:
    rlimit before_;
    void (*signal_)(int);
};

TEST_F(LineFiles, AFullDiskLeavesWholeLinesAndWhatWaitsIsWrittenOnceThereIsRoom) {
    auto file = LineFile::create(folder / "a.csv", "time\n");
    ASSERT_TRUE(file) << file.error().message;
    file->add("first line\n");
    ASSERT_TRUE(file->flush());
    {
        const SmallDisk full(20);
        file->add("second line\n");
        const auto flushed = file->flush();
        ASSERT_FALSE(flushed);
        EXPECT_NE(flushed.error().message.find("make room"), std::string::npos) << flushed.error().message;
        EXPECT_EQ(*read_text(folder / "a.csv"), "time\nfirst line\n");
    }
    file->add("third line\n");
    ASSERT_TRUE(file->flush());
    EXPECT_EQ(*read_text(folder / "a.csv"), "time\nfirst line\nsecond line\nthird line\n");
    EXPECT_EQ(file->bytes(), 39);
}

TEST_F(LineFiles, APictureThatDoesNotFitLeavesNothing) {
    {
        const SmallDisk full(20);
        ASSERT_FALSE(write_whole(folder / "frame.jpg", std::string(100, 'x')));
    }
    EXPECT_TRUE(std::filesystem::is_empty(folder));
    ASSERT_TRUE(write_whole(folder / "frame.jpg", std::string(100, 'x')));
    EXPECT_EQ(read_text(folder / "frame.jpg")->size(), 100U);
}

TEST_F(LineFiles, WhereNothingCanBeWrittenForLongTheRestIsCounted) {
    auto file = LineFile::create(folder / "a.csv", "time\n");
    ASSERT_TRUE(file);
    const SmallDisk full(5);
    for (int i = 0; i < 5000; ++i) file->add(std::string(999, 'x') + '\n');
    EXPECT_FALSE(file->flush());
    EXPECT_EQ(file->lost_lines(), 1000);
}

Site sensing_site() {
    Site site;
    site.robots.resize(2);
    site.robots[0].id = "r1";
    site.robots[1].id = "r2";
    site.robots[1].receivers.resize(2);
    site.robots[1].receivers[0].id = "front";
    site.robots[1].receivers[1].id = "rear";
    site.beacons = {{"n1"}, {"n2"}};
    site.landmarks.resize(1);
    site.landmarks[0].id = "post";
    return site;
}

TEST_F(LineFiles, WhatIsRecordedOfSensesReadsBackToTheSameBits) {
    const Site site = sensing_site();
    const double third = 1.0 / 3;
    const RangeObservation range{1'700'000'000'123'456'789, 1, 1, third, 0.1 + 0.2, 1};
    const RangeDifferenceObservation difference{1'700'000'000'223'456'789, 0, {1, 0}, -third, 0.07, 0};
    const OdometryObservation pose{-5, 1, {third, -2 * third, 1e-17}};
    const SightingObservation bearing{7, 1, 0, std::nullopt, -third, 0.05, 0.123456789012345};
    ASSERT_TRUE(write_whole(folder / "ranges.csv", std::string(range_columns) + sensed_line(range, site) + std::string(range_difference_columns) +
                                                       sensed_line(difference, site) + std::string(range_columns) + sensed_line(range, site)));
    ASSERT_TRUE(write_whole(folder / "odometry.csv", std::string(odometry_columns) + sensed_line(pose, site)));
    ASSERT_TRUE(write_whole(folder / "sightings.csv", std::string(sighting_columns) + sensed_line(bearing, site)));

    const auto ranges = load_ranges((folder / "ranges.csv").string(), site, 0);
    ASSERT_TRUE(ranges) << ranges.error().message;
    ASSERT_EQ(ranges->ranges.size(), 2U) << (ranges->problems.empty() ? "" : ranges->problems[0]);
    const RangeObservation& heard = ranges->ranges[1];
    EXPECT_EQ(std::tie(heard.time, heard.robot, heard.beacon, heard.range, heard.sigma, heard.receiver),
              std::tie(range.time, range.robot, range.beacon, range.range, range.sigma, range.receiver));
    ASSERT_EQ(ranges->differences.size(), 1U);
    const RangeDifferenceObservation& later = ranges->differences[0];
    EXPECT_EQ(std::tie(later.time, later.robot, later.beacons, later.difference, later.sigma),
              std::tie(difference.time, difference.robot, difference.beacons, difference.difference, difference.sigma));
    const auto odometry = load_odometry((folder / "odometry.csv").string(), site, 0);
    ASSERT_TRUE(odometry) << odometry.error().message;
    ASSERT_EQ(odometry->poses.size(), 1U);
    const OdometryObservation& driven = odometry->poses[0];
    EXPECT_EQ(std::tie(driven.time, driven.robot, driven.pose.x, driven.pose.y, driven.pose.yaw),
              std::tie(pose.time, pose.robot, pose.pose.x, pose.pose.y, pose.pose.yaw));
    const auto sightings = load_sightings((folder / "sightings.csv").string(), site, 0);
    ASSERT_TRUE(sightings) << sightings.error().message;
    ASSERT_EQ(sightings->sightings.size(), 1U);
    const SightingObservation& seen = sightings->sightings[0];
    EXPECT_EQ(std::tie(seen.time, seen.robot, seen.landmark, seen.range, seen.bearing, seen.bearing_sigma),
              std::tie(bearing.time, bearing.robot, bearing.landmark, bearing.range, bearing.bearing, bearing.bearing_sigma));
}

/// Half of "0.25" is "0.2": a number, too.
TEST_F(LineFiles, OnlyOfARecordingThatWasCutOffTheLastLineWithoutEndIsLeftOut) {
    const Site site = sensing_site();
    const std::string cut = "time,robot,x,y,yaw\n1,r1,0,0,0.25\n2,r1,0,0,0.2";
    ASSERT_TRUE(write_whole(folder / "odometry.csv", cut));
    EXPECT_EQ(load_odometry((folder / "odometry.csv").string(), site, 0)->poses.size(), 2U) << "somebody's own file";
    ASSERT_TRUE(write_whole(folder / unfinished_mark, ""));
    const auto odometry = load_odometry((folder / "odometry.csv").string(), site, 0);
    ASSERT_EQ(odometry->poses.size(), 1U);
    ASSERT_EQ(odometry->problems.size(), 1U);
    EXPECT_NE(odometry->problems[0].find("cut off"), std::string::npos) << odometry->problems[0];
}

}  // namespace
}  // namespace roomfix
