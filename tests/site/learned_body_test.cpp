#include "roomfix/site/learned_body.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <numbers>

#include "roomfix/site/body_parts.hpp"
#include "roomfix/site/load_site.hpp"
#include "roomfix/site/site_text.hpp"

namespace roomfix {
namespace {

namespace fs = std::filesystem;

/// A folder of its own for each test.
class LearnedBodyFile : public ::testing::Test {
protected:
    void SetUp() override {
        folder = fs::temp_directory_path() / (std::string("roomfix-body-") + ::testing::UnitTest::GetInstance()->current_test_info()->name());
        fs::create_directories(folder);
    }
    void TearDown() override { fs::remove_all(folder); }
    fs::path write(const std::string& name, const std::string& text) const {
        std::ofstream(folder / name) << text;
        return folder / name;
    }
    fs::path folder;
};

LearnedBody cart() {
    LearnedBody body;
    body.parts = {box_part({0.6, 0.4, 0.3}, Eigen::Isometry3d(Eigen::Translation3d(0, 0, 0.15))),
                  cylinder_part({0.1, 1.0}, Eigen::Isometry3d(Eigen::Translation3d(0.2, 0, 0.8)))};
    body.size_sigma = 0.013;
    body.symmetry = 2 * std::numbers::pi;
    body.look.spots = {{{0.1f, 0.05f, 0.3f}, {0, 0, 1}, {4.5f, 4.1f, 3.25f}, 0.12f}, {{0.3f, 0, 0.2f}, {1, 0, 0}, {3.0f, 3.5f, 5.0f}, 0.3f}};
    body.as_robot = {3.5, 0.6};
    body.as_clutter = {0.4, 0.5};
    body.learned_from = "8 moments of camera top";
    return body;
}

TEST_F(LearnedBodyFile, WhatIsWrittenIsReadAgain) {
    const LearnedBody written = cart();
    const auto read = read_learned_body(write("cart.body", learned_body_text(written)));
    ASSERT_TRUE(read) << read.error().message;
    EXPECT_TRUE(same_parts(read->parts, written.parts, 2e-4));
    EXPECT_NEAR(read->size_sigma, written.size_sigma, 1e-4);
    EXPECT_NEAR(read->symmetry, written.symmetry, 1e-4);
    ASSERT_EQ(read->look.spots.size(), 2U);
    EXPECT_LT((read->look.spots[1].place - written.look.spots[1].place).norm(), 2e-4f);
    EXPECT_FLOAT_EQ(read->look.spots[1].colour[2], 5.0f);
    EXPECT_FLOAT_EQ(read->look.spots[0].sigma, 0.12f);
    EXPECT_NEAR(read->as_robot.mean, 3.5, 1e-3);
    EXPECT_NEAR(read->as_clutter.sigma, 0.5, 1e-3);
    EXPECT_EQ(read->learned_from, written.learned_from);
}

TEST_F(LearnedBodyFile, OneOfAnotherVersionIsRefusedWithTheCure) {
    std::string text = learned_body_text(cart());
    text.replace(text.find("roomfix_body: 1"), 15, "roomfix_body: 9");
    const auto read = read_learned_body(write("old.body", text));
    ASSERT_FALSE(read);
    EXPECT_NE(read.error().message.find("another version"), std::string::npos) << read.error().message;
    EXPECT_NE(read.error().message.find("calibrate robot"), std::string::npos);
}

TEST_F(LearnedBodyFile, DamagedFilesNameTheLine) {
    const std::string whole = learned_body_text(cart());
    const std::vector<std::pair<std::string, std::string>> cases = {{"size_sigma: 0.013", "size_sigma: wide"},
                                                                    {"channels: 3", "channels: 2"},
                                                                    {"as_robot: [3.5, 0.6]", "as_robot: [3.5, 0]"},
                                                                    {"0.12]", "0.12, 7]"},
                                                                    {"parts:", "bits:"},
                                                                    {"0.12]", "0.12"}};
    for (const auto& [from, to] : cases) {
        std::string text = whole;
        ASSERT_NE(text.find(from), std::string::npos) << from;
        text.replace(text.find(from), from.size(), to);
        const auto read = read_learned_body(write("damaged.body", text));
        ASSERT_FALSE(read) << to;
        EXPECT_NE(read.error().message.find("damaged.body:"), std::string::npos) << read.error().message;
    }
    LearnedBody flat = cart();
    for (Eigen::Vector3d& p : flat.parts[0].points) p.y() = 0;
    flat.parts.resize(1);
    const auto read = read_learned_body(write("flat.body", learned_body_text(flat)));
    ASSERT_FALSE(read);
    EXPECT_NE(read.error().message.find("flat"), std::string::npos) << read.error().message;
    EXPECT_FALSE(read_learned_body(folder / "none.body"));
    EXPECT_FALSE(read_learned_body(write("empty.body", "")));
    EXPECT_FALSE(read_learned_body(write("picture.body", std::string("\x89PNG\r\n\0\0", 8))));
}

TEST_F(LearnedBodyFile, ASiteUsesItAsTheRobotsBody) {
    write("cart.body", learned_body_text(cart()));
    const LoadedSite loaded = parse_site("roomfix: 1\nsite: {name: lab}\nrobots:\n  cart: {model: cart.body}\n", folder);
    ASSERT_TRUE(loaded.usable()) << problem_text("site", loaded.problems.at(0));
    const SiteRobot& robot = loaded.site.robots[0];
    ASSERT_TRUE(robot.learned);
    EXPECT_EQ(robot.parts.size(), 2U);
    EXPECT_NEAR(robot.size_sigma, 0.013, 1e-6);
    EXPECT_NEAR(std::get<Box>(robot.shape).height, 1.3, 1e-3);
    EXPECT_NE(site_text(loaded.site).find("model: cart.body"), std::string::npos);
}

TEST_F(LearnedBodyFile, AModelThatIsNoneIsRefusedAtItsLine) {
    write("broken.body", "roomfix_body: 1\n");
    for (const auto& [model, words] :
         std::vector<std::pair<std::string, std::string>>{{"spot.jpg", "is no model"}, {"missing.body", "missing.body"}, {"broken.body", "needs"}}) {
        const LoadedSite loaded = parse_site("roomfix: 1\nsite: {name: lab}\nrobots:\n  cart: {model: " + model + "}\n", folder);
        ASSERT_FALSE(loaded.usable()) << model;
        EXPECT_EQ(loaded.problems[0].line, 4) << model;
        EXPECT_NE(loaded.problems[0].message.find(words), std::string::npos) << loaded.problems[0].message;
    }
}

TEST(Symmetry, IsSeenFromTheParts) {
    const auto at = [](double x, double y, double z) { return Eigen::Isometry3d(Eigen::Translation3d(x, y, z)); };
    constexpr double pi = std::numbers::pi;
    EXPECT_EQ(symmetry_of({cylinder_part({0.5, 1}, at(0, 0, 0.5)), cylinder_part({0.2, 0.5}, at(0, 0, 1.25))}), 0);
    EXPECT_DOUBLE_EQ(symmetry_of({box_part({0.5, 0.5, 1}, at(0, 0, 0.5))}), pi / 2);
    EXPECT_DOUBLE_EQ(symmetry_of({box_part({0.5, 0.3, 1}, at(0, 0, 0.5))}), pi);
    EXPECT_DOUBLE_EQ(symmetry_of({box_part({0.5, 0.3, 1}, at(0, 0, 0.5)), cylinder_part({0.1, 1}, at(0.1, 0, 1))}), 2 * pi);
}

}  // namespace
}  // namespace roomfix
