#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "roomfix/connect/fix_json.hpp"
#include "roomfix/connect/frame_source.hpp"
#include "roomfix/connect/web_server.hpp"
#include "roomfix/imaging/load_luma.hpp"
#include "temporary_folder.hpp"

namespace roomfix {
namespace {

namespace fs = std::filesystem;

class Folder : public TemporaryFolder {};

LumaImage grey(int value) {
    LumaImage image(32, 24);
    for (int y = 0; y < 24; ++y) std::memset(image.row(y), value, 32);
    return image;
}

TEST_F(Folder, FramesComeInTheOrderOfTheirTimesAndThenEnd) {
    ASSERT_TRUE(save_luma(folder / "900.png", grey(90)));
    ASSERT_TRUE(save_luma(folder / "1000.png", grey(100)));
    auto source = open_source(folder.string());
    ASSERT_TRUE(source);
    EXPECT_EQ((*source)->count(), 2);
    SourceFrame frame;
    ASSERT_TRUE(*(*source)->next(frame));
    EXPECT_EQ(frame.time, 900);
    ASSERT_TRUE(*(*source)->next(frame));
    EXPECT_EQ(frame.time, 1000);
    EXPECT_EQ(frame.image.row(3)[3], 100);
    EXPECT_FALSE(*(*source)->next(frame));
}

TEST_F(Folder, ADamagedFrameIsAnErrorAndTheNextOneComes) {
    std::ofstream(folder / "1.jpg") << "\xff\xd8 not a picture";
    ASSERT_TRUE(save_luma(folder / "2.png", grey(7)));
    auto source = open_source(folder.string());
    SourceFrame frame;
    const auto first = (*source)->next(frame);
    ASSERT_FALSE(first);
    EXPECT_NE(first.error().message.find("1.jpg"), std::string::npos);
    EXPECT_TRUE(*(*source)->next(frame));
}

TEST_F(Folder, WhatCannotBeOpenedSaysWhy) {
    const auto empty = open_source(folder.string());
    ASSERT_FALSE(empty);
    EXPECT_NE(empty.error().message.find("no picture in this folder"), std::string::npos);
    EXPECT_NE(open_source((folder / "nothing").string()).error().message.find("does not exist"), std::string::npos);
    std::ofstream(folder / "film.avi") << "no film";
    EXPECT_NE(open_source((folder / "film.avi").string()).error().message.find("not a video"), std::string::npos);
    EXPECT_FALSE(open_source("/dev/video77"));
}

TEST(FixJson, IsOneLineOfValidJson) {
    Fix fix;
    fix.time = 12345678901;
    fix.robot = "r\"1";
    fix.status = FixStatus::ok;
    fix.pose = {1.2345678, -2, 0.5};
    fix.covariance << 1e-4, 1e-6, 0, 1e-6, 2e-4, 0, 0, 0, 3e-5;
    fix.sources = {"hall"};
    const auto json = nlohmann::json::parse(fix_line(fix));
    EXPECT_EQ(json["robot"], "r\"1");
    EXPECT_DOUBLE_EQ(json["time"].get<double>(), 12.345678901);
    EXPECT_EQ(json["covariance"].size(), 9U);
    EXPECT_DOUBLE_EQ(json["covariance"][4].get<double>(), 2e-4);
    EXPECT_FALSE(json.contains("reason"));
    EXPECT_FALSE(json.contains("velocity"));
    fix.velocity = Eigen::Vector3d(0.25, -0.5, 0.125);
    fix.velocity_covariance = Eigen::Vector3d(0.01, 0.02, 0.03).asDiagonal();
    const auto moving = nlohmann::json::parse(fix_line(fix));
    EXPECT_EQ(moving["velocity"], nlohmann::json({0.25, -0.5, 0.125}));
    EXPECT_DOUBLE_EQ(moving["velocity_covariance"][8].get<double>(), 0.03);
    Fix none;
    none.reason = "nothing differs\nfrom the background";
    const auto nothing = nlohmann::json::parse(fix_line(none));
    EXPECT_EQ(nothing["status"], "none");
    EXPECT_FALSE(nothing.contains("x"));
    EXPECT_TRUE(nothing["robot"].is_null());
    fix.yaw_known = false;
    EXPECT_TRUE(nlohmann::json::parse(fix_line(fix))["yaw"].is_null());
}

TEST(WebServer, APortInUseIsAClearError) {
    WebServer first;
    ASSERT_TRUE(first.start({"127.0.0.1", 0}));
    WebServer second;
    const auto started = second.start({"127.0.0.1", first.port()});
    ASSERT_FALSE(started);
    EXPECT_NE(started.error().message.find("--port"), std::string::npos);
}

}  // namespace
}  // namespace roomfix
