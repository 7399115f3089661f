#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "roomfix/site/body_parts.hpp"
#include "roomfix/site/load_site.hpp"
#include "roomfix/site/site_text.hpp"

namespace roomfix {
namespace {

const char* const tracked = "parts: [{box: [0.54, 0.10, 0.26], at: [0, 0.22, 0.13], yaw_deg: 30}, {cylinder: [0.1, 0.5], at: [0.1, 0, 0.7]}]";

/// A site of robots, each given by its keys; the first stands on line 4, its keys from column 8.
LoadedSite site_of(const std::vector<std::string>& robots) {
    std::string text = "roomfix: 1\nsite: {name: lab}\nrobots:\n";
    for (std::size_t i = 0; i < robots.size(); ++i) text += "  r" + std::to_string(i) + ": {" + robots[i] + "}\n";
    return parse_site(text, "/somewhere");
}

std::string all_problems(const LoadedSite& loaded) {
    std::string all;
    for (const Problem& p : loaded.problems) all += problem_text("site", p) + "\n";
    return all;
}

TEST(RobotBody, PartsStandWhereTheyAreSaidToBe) {
    const LoadedSite loaded = site_of({tracked});
    ASSERT_TRUE(loaded.usable()) << all_problems(loaded);
    const SiteRobot& robot = loaded.site.robots[0];
    ASSERT_EQ(robot.parts.size(), 2U);
    ASSERT_EQ(robot.parts[0].points.size(), 8U);
    const double c = std::cos(std::numbers::pi / 6), s = std::sin(std::numbers::pi / 6);
    const Eigen::Vector3d front_left_top(0.27 * c - 0.05 * s, 0.22 + 0.27 * s + 0.05 * c, 0.26);
    EXPECT_LT((robot.parts[0].points[7] - front_left_top).norm(), 1e-12) << robot.parts[0].points[7].transpose();
    EXPECT_LT((robot.parts[0].points[0] - Eigen::Vector3d(-front_left_top.x(), 0.44 - front_left_top.y(), 0)).norm(), 1e-12);
}

TEST(RobotBody, ACylinderHasTwoRimsWithTheCirclesMeanRadius) {
    const ConvexPart part = site_of({tracked}).site.robots[0].parts[1];
    ASSERT_EQ(part.points.size(), 32U);
    for (std::size_t i = 0; i < 32; ++i) {
        const Eigen::Vector3d p = part.points[i];
        EXPECT_NEAR(p.z(), i < 16 ? 0.45 : 0.95, 1e-12);
        const double corner = (p.head<2>() - Eigen::Vector2d(0.1, 0)).norm();
        const double middle_of_side = corner * std::cos(std::numbers::pi / 16);
        EXPECT_NEAR((corner + middle_of_side) / 2, 0.05, 1e-5);
    }
}

TEST(RobotBody, TheShapeIsTheBoxAroundAllPartsOverTheRobotsOrigin) {
    const LoadedSite loaded = site_of({"parts: [{box: [0.4, 0.2, 0.3], at: [0.1, -0.05, 0.15]}, {box: [0.1, 0.1, 0.2], at: [0, 0, 0.4]}]"});
    ASSERT_TRUE(loaded.usable()) << all_problems(loaded);
    const auto* box = std::get_if<Box>(&loaded.site.robots[0].shape);
    ASSERT_TRUE(box);
    EXPECT_NEAR(box->length, 0.6, 1e-12);
    EXPECT_NEAR(box->width, 0.3, 1e-12);
    EXPECT_NEAR(box->height, 0.5, 1e-12);
}

TEST(RobotBody, PartsAreWrittenAsPointsAndReadBackTheSame) {
    const LoadedSite first = site_of({tracked, "shape: box, size: [0.5, 0.4, 0.3]"});
    const LoadedSite again = parse_site(site_text(first.site), "/somewhere");
    ASSERT_TRUE(again.usable()) << all_problems(again) << site_text(first.site);
    const auto& parts = again.site.robots[0].parts;
    ASSERT_EQ(parts.size(), 2U);
    EXPECT_TRUE(same_parts(first.site.robots[0].parts, parts, 1e-12));
    EXPECT_TRUE(again.site.robots[1].parts.empty());
    EXPECT_EQ(site_text(again.site), site_text(first.site));
}

TEST(RobotBody, RobotsOfTheSamePartsLookAlikeAndOthersDoNot) {
    const std::string box = "{box: [0.6, 0.4, 0.3], at: [0, 0, 0.15]}";
    const auto with_mast = [&](const char* at, const char* height = "0.5") {
        return "parts: [" + box + ", {cylinder: [0.1, " + height + "], at: " + at + "}]";
    };
    const LoadedSite loaded = site_of({with_mast("[0.2, 0, 0.55]"), "parts: [{cylinder: [0.1, 0.5], at: [0.201, 0, 0.55]}, " + box + "]",
                                       with_mast("[-0.2, 0, 0.55]"), "shape: box, size: [0.6, 0.4, 0.8]", with_mast("[0.2, 0, 0.5]", "0.4")});
    ASSERT_TRUE(loaded.usable()) << all_problems(loaded);
    const auto& robots = loaded.site.robots;
    EXPECT_TRUE(look_alike(robots[0], robots[0]));
    EXPECT_TRUE(look_alike(robots[0], robots[1])) << "a millimetre, and another order";
    EXPECT_FALSE(look_alike(robots[0], robots[2])) << "the mast at the other end, in the same box";
    EXPECT_FALSE(look_alike(robots[0], robots[3])) << "a plain box of that size";
    EXPECT_FALSE(look_alike(robots[0], robots[4])) << "a shorter mast";
}

TEST(RobotBody, SaysWhatIsWrongWithPartsAndWhere) {
    const struct {
        const char* keys;
        const char* words;
        int column;
    } cases[] = {
        {"count: many", "needs a body: shape and size, or parts, or model", 7},
        {"parts: []", "has 0 parts: write 1 to 64", 15},
        {"parts: {}", "parts must be a list, not a map", 15},
        {"parts: [{ball: [1], at: [0, 0, 1]}]", "has no key 'ball'", 17},
        {"parts: [{at: [0, 0, 1]}]", "parts[0] needs one of box", 16},
        {"parts: [{box: [1, 1, 1], cylinder: [1, 1], at: [0, 0, 1]}]", "parts[0] needs only one of box", 16},
        {"parts: [{box: [1, 1, 1]}]", "parts[0] needs the key 'at'", 16},
        {"parts: [{box: [1, 1], at: [0, 0, 0.5]}]", "must be a list of 3 numbers", 22},
        {"parts: [{cylinder: [1, 0], at: [0, 0, 0.5]}]", "must lie between", 31},
        {"parts: [{box: [1, 1, 1], at: [0, 0, 1e4]}]", "must lie between", 44},
        {"parts: [{box: [1, 1, 1], at: [0, 0, 0.6]}]", "the lowest point is 0.10 m above the floor", 15},
        {"parts: [{box: [1, 1, 1], at: [0, 0, 0.4]}]", "the lowest point is 0.10 m below the floor", 15},
        {"parts: [{points: [[0, 0, 0], [1, 0, 0], [0, 1, 0]]}]", "has 3 points: a convex part is made of 4 to 64", 25},
        {"parts: [{points: [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]]}]", "are flat", 15},
        {"parts: [{points: [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 1]], at: [0, 0, 1]}]", "at belongs to a box or a cylinder", 75},
        {"shape: box, size: [1, 1, 1], parts: [{box: [1, 1, 1], at: [0, 0, 0.5]}]", "keep one of them", 44},
    };
    for (const auto& c : cases) {
        const LoadedSite loaded = site_of({c.keys});
        EXPECT_FALSE(loaded.usable()) << c.keys;
        ASSERT_FALSE(loaded.problems.empty()) << c.keys;
        const auto found =
            std::find_if(loaded.problems.begin(), loaded.problems.end(), [&](const Problem& p) { return p.message.find(c.words) != std::string::npos; });
        ASSERT_NE(found, loaded.problems.end()) << c.words << "\n" << all_problems(loaded);
        EXPECT_EQ(found->line, 4) << c.keys;
        EXPECT_EQ(found->column, c.column) << c.keys;
    }
}

TEST(RobotBody, AGapOfAFewCentimetresBelowTheBodyIsAccepted) {
    EXPECT_TRUE(site_of({"parts: [{box: [1, 1, 1], at: [0, 0, 0.54]}]"}).usable());
    EXPECT_TRUE(site_of({"parts: [{box: [1, 1, 1], at: [0, 0, 0.495]}]"}).usable());
}

}  // namespace
}  // namespace roomfix
