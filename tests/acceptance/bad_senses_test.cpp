// Recordings whose senses are not what the formats ask for: each mistake is told as such, and a good recording is not accused.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>

#include "program.hpp"
#include "roomfix/base/random.hpp"
#include "roomfix/geometry/pose.hpp"

namespace roomfix {
namespace {

namespace fs = std::filesystem;

constexpr double duration = 45;  // s

/// What is done to a good recording before it is written.
struct Mistake {
    double odometry_way = 1, odometry_turn = 1;  // units
    bool mirrored = false;                       // left and right exchanged
    double odometry_clock = 0;                   // s that the wheels' times are late
    double range = 1;                            // unit
    int moved = -1;                              // beacon that stands elsewhere than the site says ...
    Eigen::Vector2d by = {0, 0};                 // ... by so much, m
    std::pair<int, int> exchanged = {-1, -1};
    bool receiver = true;  // the site file has one
};

struct Beacon {
    const char* id;
    Eigen::Vector3d position;
};
const Beacon beacons[] = {{"b1", {0.2, 0.1, 1.9}}, {"b2", {7.8, 0.3, 2.1}}, {"b3", {7.6, 5.9, 1.8}}, {"b4", {0.1, 5.7, 2.2}}, {"b5", {4.2, 6.1, 1.5}}};
constexpr int beacon_count = 5;

/// A session folder with a drive of wavy circles through a room of 8 m x 6 m, ranges one at a time at 10 Hz, wheels at 20 Hz.
fs::path session_with(const std::string& name, const Mistake& mistake, std::uint64_t seed) {
    const fs::path folder = fs::path(testing::TempDir()) / ("bad-senses-" + name);
    fs::create_directories(folder);
    std::ofstream site(folder / "site.yaml");
    site << "roomfix: 1\nsite: {name: hall}\nbeacons:\n";
    for (const Beacon& b : beacons) site << fmt::format("  {}: {{position: [{}, {}, {}]}}\n", b.id, b.position.x(), b.position.y(), b.position.z());
    site << "robots:\n  r1: {shape: cylinder, size: [0.4, 0.5]" << (mistake.receiver ? ", receiver: {position: [0.05, 0, 0.4]}" : "") << "}\n";
    std::ofstream ranges(folder / "ranges.csv"), odometry(folder / "odometry.csv"), truth(folder / "truth.csv");
    ranges << "time,robot,beacon,range\n";
    odometry << "time,robot,x,y,yaw\n";
    truth << "time,robot,x,y,yaw\n";
    Random random(seed);
    Pose2 pose{3.0, 1.5, 0.4}, driven{0, 0, 0};
    constexpr double step = 0.01;
    for (int i = 0; i * step < duration; ++i) {
        const double t = i * step;
        const double speed = 0.35 + 0.1 * std::sin(0.2 * t), turn = 0.22 + 0.5 * std::sin(0.31 * t);
        if (i % 5 == 0) {
            const double side = mistake.mirrored ? -1 : 1;
            odometry << fmt::format("{:.3f},r1,{:.5f},{:.5f},{:.6f}\n", 1000 + t + mistake.odometry_clock, mistake.odometry_way * driven.x,
                                    side * mistake.odometry_way * driven.y, side * mistake.odometry_turn * driven.yaw);
            truth << fmt::format("{:.3f},r1,{:.5f},{:.5f},{:.6f}\n", 1000 + t, pose.x, pose.y, wrap_angle(pose.yaw));
        }
        if (i % 10 == 3) {
            const int said = (i / 10) % beacon_count;
            int heard = said;
            if (said == mistake.exchanged.first) heard = mistake.exchanged.second;
            if (said == mistake.exchanged.second) heard = mistake.exchanged.first;
            Eigen::Vector3d from = beacons[heard].position;
            if (heard == mistake.moved) from.head<2>() += mistake.by;
            const Eigen::Vector3d receiver = map_from_robot(pose) * Eigen::Vector3d(0.05, 0, 0.4);
            ranges << fmt::format("{:.3f},r1,{},{:.4f}\n", 1000 + t, beacons[said].id, mistake.range * ((receiver - from).norm() + random.normal(0.04)));
        }
        const double moved = speed * step * (1 + random.normal(0.05)), turned = turn * step * (1 + random.normal(0.05));
        pose = {pose.x + speed * step * std::cos(pose.yaw), pose.y + speed * step * std::sin(pose.yaw), pose.yaw + turn * step};
        driven = {driven.x + moved * std::cos(driven.yaw), driven.y + moved * std::sin(driven.yaw), driven.yaw + turned};
    }
    return folder;
}

Outcome replayed(const std::string& name, const Mistake& mistake, std::uint64_t seed) {
    const fs::path folder = session_with(name, mistake, seed);
    return call(fmt::format("replay {} --fixes {}", folder.string(), (folder / "fixes.jsonl").string()));
}

TEST(BadSenses, AGoodRecordingIsNotAccused) {
    const Outcome outcome = replayed("good", {}, 1);
    EXPECT_EQ(outcome.code, 0);
    EXPECT_EQ(outcome.text.find("look at this"), std::string::npos) << outcome.text;
    EXPECT_EQ(outcome.text.find("not used"), std::string::npos) << outcome.text;
}

TEST(BadSenses, OdometryInDegrees) { expect_says(replayed("degrees", {.odometry_turn = degrees(1)}, 2), 0, "only if it is in degrees"); }

TEST(BadSenses, OdometryInMillimetres) { expect_says(replayed("millimetres", {.odometry_way = 1000}, 3), 0, "seem to be in millimetres"); }

TEST(BadSenses, OdometryWithLeftAndRightExchanged) { expect_says(replayed("mirrored", {.mirrored = true}, 4), 0, "left and right seem to be exchanged"); }

TEST(BadSenses, RangesInFeet) { expect_says(replayed("feet", {.range = 1 / 0.3048}, 5), 0, "ranges seem to be in feet"); }

TEST(BadSenses, ABeaconThatWasMoved) {
    const Outcome outcome = replayed("moved", {.moved = 2, .by = {-1.5, -0.6}}, 6);
    expect_says(outcome, 0, "beacon b3 seems to be at (6.");
}

TEST(BadSenses, ExchangedBeacons) { expect_says(replayed("exchanged", {.exchanged = {0, 2}}, 8), 0, "beacons b1 and b3 seem to be exchanged"); }

TEST(BadSenses, ClocksApart) { expect_says(replayed("clocks", {.odometry_clock = -0.3}, 9), 0, "the clocks of its odometry"); }

TEST(BadSenses, ARobotWithoutReceiverIsHeardSomewhereOnItself) {
    const Mistake mistake{.receiver = false};
    const fs::path folder = session_with("no-receiver", mistake, 10);
    const std::string fixes = (folder / "fixes.jsonl").string();
    EXPECT_EQ(call(fmt::format("replay {} --fixes {}", folder.string(), fixes)).code, 0);
    // It may sit anywhere in the robot's box: that is a part of the uncertainty, and no reason for places that are wrong.
    const Outcome judged = call(fmt::format("evaluate {} --truth {} --json {}", fixes, (folder / "truth.csv").string(), (folder / "figures.json").string()));
    EXPECT_EQ(judged.code, 0) << judged.text;
}

}  // namespace
}  // namespace roomfix
