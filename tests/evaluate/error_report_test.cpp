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

TEST(ErrorReport, ANameThatIsAnotherRobotsFromTheStartIsNoSwitch) {
    RecordedFixes recorded;
    for (int i = 0; i < 100; ++i) {
        recorded.fixes.push_back(fix_at(0.1 * i, "r1", 0.1 * i, 3.01, 0, 0.02));
        recorded.fixes.back().identity = 0.5;
        recorded.fixes.push_back(fix_at(0.1 * i, "r2", 0.1 * i, -0.01, 0, 0.02));
    }
    const ErrorReport report = judge(recorded, two_robots());
    EXPECT_EQ(report.identity_switches, 0);
    EXPECT_EQ(report.misnamed, 2);
    EXPECT_EQ(report.flagged_misnamed, 1);
    EXPECT_NEAR(report.followed_rms, 0.01, 1e-9);
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
    EXPECT_EQ(report.misnamed, 0);
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

TEST(RecordedFixes, HaveTheirVelocity) {
    const std::string fix = "{\"time\": 1, \"robot\": \"r1\", \"status\": \"ok\", \"x\": 1, \"y\": 2, \"yaw\": 0, \"covariance\": [1,0,0,0,1,0,0,0,1], ";
    const RecordedFixes recorded = parse_fixes(fix + "\"velocity\": [0.5, -0.25, 0.1], \"velocity_covariance\": [4,1,0,1,5,0,0,0,6]}\n" +  //
                                               fix + "\"velocity\": [0.5, -0.25, 0.1]}\n" +                                                //
                                               fix + "\"velocity\": [0.5], \"velocity_covariance\": [4,1,0,1,5,0,0,0,6]}\n");
    ASSERT_EQ(recorded.fixes.size(), 1U);
    ASSERT_TRUE(recorded.fixes[0].velocity);
    EXPECT_EQ(*recorded.fixes[0].velocity, Eigen::Vector3d(0.5, -0.25, 0.1));
    EXPECT_EQ(recorded.fixes[0].velocity_covariance(0, 1), 1);
    EXPECT_EQ(recorded.fixes[0].velocity_covariance(2, 2), 6);
    EXPECT_EQ(recorded.problems.size(), 2U);
}

/// The truth that knows places only.
Truth without_yaws(Truth truth) {
    for (auto& [robot, poses] : truth) {
        for (StampedPose& pose : poses) pose = {pose.time, {pose.pose.x, pose.pose.y, 0}, false};
    }
    return truth;
}

/// r1 as it drives, with its yaw 0.5 rad off and all else exact.
RecordedFixes turned_fixes() {
    RecordedFixes recorded;
    for (int i = 0; i < 200; ++i) recorded.fixes.push_back(fix_at(0.1 * i, "r1", 0.1 * i, 0, 0.5, 0.02));
    return recorded;
}

TEST(ErrorReport, JudgesThePlaceAloneWhereTheTruthHasNoYaw) {
    Random random(3);
    RecordedFixes recorded;
    for (int i = 0; i < 2000; ++i) {
        const double t = 0.01 * i;
        recorded.fixes.push_back(fix_at(t, "r1", t + random.normal(0.02), random.normal(0.02), 0.5, 0.02));
    }
    EXPECT_GT(judge(recorded, two_robots()).all.nees.mean, 100) << "the yaw is off by far more than stated";
    const ErrorReport report = judge(recorded, without_yaws(two_robots()));
    EXPECT_NEAR(report.all.nees.mean, 1, 0.1);
    EXPECT_NEAR(report.all.position.rms, 0.02 * std::numbers::sqrt2, 0.002);
    EXPECT_EQ(report.all.yaw.count, 0U);
    EXPECT_EQ(report.fixes.front().dimensions, 2);
    EXPECT_EQ(report.without_true_yaw, 2000U);
    EXPECT_NE(text_of(report).find("no yaw beside 2000 of 2000 fixes"), std::string::npos) << text_of(report);
    EXPECT_NE(html_of(report, "t").find("no yaw beside 2000 of 2000 fixes"), std::string::npos);
    EXPECT_NE(json_of(report).find("\"without_true_yaw\": 2000"), std::string::npos);
}

TEST(ErrorReport, ComparesWaysInTheMapWhereAYawIsMissing) {
    EXPECT_GT(judge(turned_fixes(), two_robots()).relative_position.rms, 0.4) << "seen from the robot, it drives 0.5 rad to the side";
    const ErrorReport report = judge(turned_fixes(), without_yaws(two_robots()));
    EXPECT_GT(report.relative_position.count, 100U);
    EXPECT_LT(report.relative_position.max, 1e-9);
    EXPECT_EQ(report.relative_yaw.count, 0U);
}

TEST(ErrorReport, JudgesTheYawWhereSomeLinesOfTheTruthHaveOne) {
    Truth truth = two_robots();
    for (std::size_t i = 101; i <= 200; ++i) truth["r1"][i].yaw_known = false;
    const ErrorReport report = judge(turned_fixes(), truth);
    EXPECT_EQ(report.all.position.count, 200U);
    EXPECT_EQ(report.all.yaw.count, 101U);
    EXPECT_NEAR(report.all.yaw.rms, 0.5, 1e-9);
    EXPECT_EQ(report.without_true_yaw, 99U);
}

/// A prism 0.3 m ahead and 0.1 m left of the middle of a robot that turns as it drives; places and yaws have the errors that are stated.
TEST(ErrorReport, ComparesAnotherPointOfTheRobotWithTheCovarianceOfThatPoint) {
    Random random(5);
    const Eigen::Vector2d point(0.3, 0.1);
    constexpr double sigma = 0.002, yaw_sigma = 0.05;
    RecordedFixes recorded;
    Truth truth;
    for (int i = 0; i < 4000; ++i) {
        const double t = 0.01 * i, yaw = wrap_angle(0.4 * t);
        const Eigen::Vector2d prism = Eigen::Vector2d(0.2 * t, 1) + Eigen::Rotation2Dd(yaw) * point;
        truth["r1"].push_back({from_seconds(t), {prism.x(), prism.y(), 0}, false});
        recorded.fixes.push_back(fix_at(t, "r1", 0.2 * t + random.normal(sigma), 1 + random.normal(sigma), yaw + random.normal(yaw_sigma), sigma));
        recorded.fixes.back().covariance(2, 2) = yaw_sigma * yaw_sigma;
    }
    EXPECT_GT(judge(recorded, truth).all.position.rms, 0.3) << "the middle is not the prism";
    const ErrorReport report = judge(recorded, truth, {.point = point});
    const double expected = std::hypot(std::numbers::sqrt2 * sigma, yaw_sigma * point.norm());
    EXPECT_NEAR(report.all.position.rms, expected, 0.05 * expected);
    EXPECT_NEAR(report.all.stated_sigma, expected, 1e-9);
    EXPECT_NEAR(report.all.nees.mean, 1, 0.1);
    EXPECT_TRUE(report.without_point.empty());
}

TEST(ErrorReport, LeavesOutFixesWithoutAYawWhereAnotherPointIsCompared) {
    RecordedFixes recorded = turned_fixes();
    for (std::size_t i = 0; i < 50; ++i) recorded.fixes[i].yaw_known = false;
    const ErrorReport report = judge(recorded, two_robots(), {.point = {0.2, 0}});
    EXPECT_EQ(report.all.position.count, 150U);
    EXPECT_EQ(report.without_point.at("r1"), 50U);
    EXPECT_NE(text_of(report).find("Robot r1: 50 fixes have no yaw"), std::string::npos) << text_of(report);
    EXPECT_EQ(judge(recorded, two_robots()).all.position.count, 200U) << "the middle is where it is, with a yaw or without";
}

TEST(RecordedTruth, MayHaveNoYawAtAllOrNoneInSomeLines) {
    const auto places = parse_truth("time,robot,x,y\n1,r1,2,3\n2,r1,4,5\n");
    ASSERT_TRUE(places) << places.error().message;
    EXPECT_FALSE(places->at("r1")[0].yaw_known);
    const auto half = pose_at(places->at("r1"), from_seconds(1.5));
    ASSERT_TRUE(half);
    EXPECT_NEAR(half->x, 3, 1e-12);
    EXPECT_NEAR(half->y, 4, 1e-12);
    EXPECT_FALSE(half->yaw_known);
    const auto some = parse_truth("time,robot,x,y,yaw\n0,r1,0,0,0.4\n0.5,r1,1,0,\n1,r1,2,0,0.6\n1.5,r1,3,0, \n9,r1,4,0,1\n");
    ASSERT_TRUE(some) << some.error().message;
    const auto between = pose_at(some->at("r1"), from_seconds(0.5)), beyond = pose_at(some->at("r1"), from_seconds(1.5));
    ASSERT_TRUE(between && beyond);
    EXPECT_TRUE(between->yaw_known);
    EXPECT_NEAR(between->yaw, 0.5, 1e-12);
    EXPECT_FALSE(beyond->yaw_known) << "the next yaw comes eight seconds later";
}

TEST(RecordedTruth, IsNotReadPastADamagedLine) {
    EXPECT_FALSE(parse_truth("time,robot,x,y,yaw\n1,r1,0,0\n")) << "the line was cut off";
    EXPECT_FALSE(parse_truth("time,robot,x,y\n1,r1,0,0,0.5\n")) << "a column that the first line does not name";
    EXPECT_FALSE(parse_truth("time,robot,x,y,heading\n1,r1,0,0,0.5\n"));
    EXPECT_FALSE(parse_truth("time,robot,x,y,yaw\n1,r1,0,,0.5\n"));
    const auto bad = parse_truth("time,robot,x,y,yaw\n1,r1,0,0,nan\n");
    ASSERT_FALSE(bad);
    EXPECT_NE(bad.error().message.find("a yaw that is not known is left empty"), std::string::npos);
}

TEST(RecordedTruth, NamesTheLineThatCannotBeRead) {
    EXPECT_FALSE(parse_truth("t,x,y\n1,2,3\n"));
    EXPECT_FALSE(parse_truth(""));
    const auto bad = parse_truth("time,robot,x,y,yaw\n1,r1,0,0,0\n2,r1,zero,0,0\n");
    ASSERT_FALSE(bad);
    EXPECT_EQ(bad.error().message.rfind("line 3: '2,r1,zero,0,0' is not time,robot,x,y,yaw", 0), 0U) << bad.error().message;
}

TEST(RecordedTruth, GoesIntoATumFileWithYawZeroWhereThereIsNone) { EXPECT_EQ(tum_text({{from_seconds(1.5), {2, 3, 1}, false}}), "1.5 2 3 0 0 0 0 1\n"); }

TEST(RecordedTruth, IsInterpolatedTheShortWayAround) {
    const std::vector<StampedPose> poses = {{0, {0, 0, 3.1}}, {from_seconds(1.0), {1, 0, -3.1}}};
    const auto half = pose_at(poses, from_seconds(0.5));
    ASSERT_TRUE(half);
    EXPECT_NEAR(std::abs(half->yaw), std::numbers::pi, 1e-9);
    EXPECT_FALSE(pose_at(poses, from_seconds(1.5)));
}

}  // namespace
}  // namespace roomfix
