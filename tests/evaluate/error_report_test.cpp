#include "roomfix/evaluate/error_report.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <numbers>

#include "roomfix/base/random.hpp"

namespace roomfix {
namespace {

/// Two robots that drive side by side.
Truth two_robots() {
    Truth truth;
    for (int i = 0; i <= 200; ++i) {
        truth["r1"].push_back({from_seconds(0.1 * i), {0.1 * i, 0, 0}});
        truth["r2"].push_back({from_seconds(0.1 * i), {0.1 * i, 3, 0}});
    }
    return truth;
}

Fix fix_at(double t, const std::string& robot, double x, double y, double yaw, double sigma) {
    Fix fix;
    fix.time = from_seconds(t);
    fix.robot = robot;
    fix.status = FixStatus::ok;
    fix.pose = {x, y, yaw};
    fix.covariance = Eigen::Vector3d(sigma * sigma, sigma * sigma, 1e-4).asDiagonal();
    fix.sources = {"hall"};
    return fix;
}

TEST(ErrorReport, HonestFixesHaveANeesOfOneAndTheirOwnRmse) {
    Random random(1);
    RecordedFixes recorded;
    for (int i = 0; i < 2000; ++i) {
        const double t = 0.01 * i;
        recorded.fixes.push_back(fix_at(t, "r1", t + random.normal(0.02), random.normal(0.02), random.normal(0.01), 0.02));
    }
    const ErrorReport report = judge(recorded, two_robots());
    EXPECT_NEAR(report.all.nees.mean, 1, 0.1);
    EXPECT_NEAR(report.all.position.rms, 0.02 * std::numbers::sqrt2, 0.002);
    EXPECT_NEAR(report.all.stated_sigma, 0.02 * std::numbers::sqrt2, 1e-9);
    EXPECT_EQ(report.all.nees.independent, 10U);
    EXPECT_NEAR(report.availability, 0.5, 0.01);  // nothing of r2
    EXPECT_EQ(report.identity_switches, 0);
}

TEST(ErrorReport, SetsErrorsBesideTheBoundWhereItIsKnown) {
    Random random(2);
    RecordedFixes recorded;
    std::vector<std::optional<Eigen::Matrix3d>> bounds;
    for (int i = 0; i < 2000; ++i) {
        const double t = 0.01 * i;
        recorded.fixes.push_back(fix_at(t, "r1", t + random.normal(0.02), random.normal(0.02), 0, 0.02));
        bounds.emplace_back();
        if (i >= 1000) bounds.back() = 1e-4 * Eigen::Matrix3d::Identity();
    }
    const ErrorReport report = judge(recorded, two_robots(), {}, bounds);
    EXPECT_NEAR(report.all.bound, 0.01 * std::numbers::sqrt2, 1e-9);
    EXPECT_NEAR(report.all.over_bound, 2, 0.15);
    EXPECT_NE(text_of(report).find("rmse/bound"), std::string::npos);
    EXPECT_NE(json_of(report).find("rmse_over_bound"), std::string::npos);
    EXPECT_NE(html_of(report, "t").find("rmse / bound"), std::string::npos);
    EXPECT_EQ(text_of(judge(recorded, two_robots())).find("bound"), std::string::npos);
}

TEST(ErrorReport, SumsUpTheLatencyOfFixesThatStateOne) {
    std::string lines;
    for (int i = 1; i <= 100; ++i) {
        lines += fmt::format(
            "{{\"time\": {:.2f}, \"robot\": \"r1\", \"status\": \"ok\", \"x\": 0, \"y\": 0, \"yaw\": 0, "
            "\"covariance\": [1e-4, 0, 0, 0, 1e-4, 0, 0, 0, 1e-4], \"sources\": [\"hall\"]{}}}\n",
            0.1 * i, i % 2 == 0 ? fmt::format(", \"latency\": {:.3f}", 0.001 * i) : "");
    }
    const ErrorReport report = judge(parse_fixes(lines), two_robots());
    EXPECT_EQ(report.latency.count, 50U);
    EXPECT_NEAR(report.latency.mean, 0.051, 1e-9);
    EXPECT_NEAR(report.latency.max, 0.1, 1e-9);
    EXPECT_NE(text_of(report).find("Latency from frame to fix: mean 51 ms"), std::string::npos);
    EXPECT_NE(json_of(report).find("\"latency\""), std::string::npos);
    EXPECT_NE(html_of(report, "t").find("Latency from frame to fix"), std::string::npos);
    EXPECT_EQ(text_of(judge({}, two_robots())).find("Latency"), std::string::npos);
}

TEST(ErrorReport, CountsANameThatMovesToAnotherRobotAndWhetherThatWasFlagged) {
    RecordedFixes recorded;
    for (int i = 0; i < 200; ++i) {
        const double t = 0.1 * i;
        const bool swapped = i >= 80 && i < 140;
        recorded.fixes.push_back(fix_at(t, "r1", t, swapped ? 3 : 0, 0, 0.02));
        if (i > 70 && i < 81) recorded.fixes.back().identity = 0.6;
    }
    const ErrorReport report = judge(recorded, two_robots());
    EXPECT_EQ(report.identity_switches, 2);  // there and back
    EXPECT_EQ(report.flagged_switches, 1);
}

TEST(ErrorReport, NamesRobotsThatTheTruthDoesNotKnow) {
    RecordedFixes recorded;
    recorded.fixes = {fix_at(1, "r1", 1, 0, 0, 0.02), fix_at(1, "ghost", 1, 0, 0, 0.02)};
    const ErrorReport report = judge(recorded, two_robots());
    ASSERT_EQ(report.unknown_robots, std::vector<std::string>{"ghost"});
    EXPECT_EQ(report.all.position.count, 1U);
}

TEST(RecordedFixes, GoOnAfterABadLineAndKeepEveryNanosecond) {
    const RecordedFixes recorded = parse_fixes(
        "{\"time\": 1700000000.123456789, \"robot\": \"r1\", \"status\": \"ok\", \"x\": 1, \"y\": 2, \"yaw\": null, \"covariance\": [1,0,0,0,1,0,0,0,1]}\n"
        "not json\n"
        "{\"time\": 5, \"robot\": \"r1\", \"status\": \"fine\"}\n"
        "{\"time\": 6, \"robot\": \"r1\", \"status\": \"ok\", \"x\": 1, \"y\": 2, \"yaw\": 0, \"covariance\": [1,0,0]}\n"
        "{\"time\": 7, \"robot\": \"r1\", \"status\": \"none\", \"reason\": \"gone\"}\n");
    ASSERT_EQ(recorded.fixes.size(), 2U);
    EXPECT_EQ(recorded.fixes[1].time, 1700000000123456789);
    EXPECT_FALSE(recorded.fixes[1].yaw_known);
    ASSERT_EQ(recorded.problems.size(), 3U);
    EXPECT_EQ(recorded.problems[0].rfind("line 2: ", 0), 0U);
}

TEST(RecordedTruth, NamesTheLineThatCannotBeRead) {
    EXPECT_FALSE(parse_truth("t,x,y\n1,2,3\n"));
    EXPECT_FALSE(parse_truth(""));
    const auto bad = parse_truth("time,robot,x,y,yaw\n1,r1,0,0,0\n2,r1,zero,0,0\n");
    ASSERT_FALSE(bad);
    EXPECT_EQ(bad.error().message, "line 3: '2,r1,zero,0,0' is not time,robot,x,y,yaw");
}

TEST(RecordedTruth, IsInterpolatedTheShortWayAround) {
    const std::vector<StampedPose> poses = {{0, {0, 0, 3.1}}, {from_seconds(1.0), {1, 0, -3.1}}};
    const auto half = pose_at(poses, from_seconds(0.5));
    ASSERT_TRUE(half);
    EXPECT_NEAR(std::abs(half->yaw), std::numbers::pi, 1e-9);
    EXPECT_FALSE(pose_at(poses, from_seconds(1.5)));
}

}  // namespace
}  // namespace roomfix
