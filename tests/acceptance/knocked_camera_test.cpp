// Somebody bumps into a camera while it watches a robot.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "acceptance/program.hpp"
#include "roomfix/imaging/load_luma.hpp"
#include "roomfix/simulate/scenario_renderer.hpp"

namespace roomfix {
namespace {

TEST(KnockedCamera, IsToldAndItsRobotsStayWhereTheyAre) {
    namespace fs = std::filesystem;
    const fs::path folder = fs::temp_directory_path() / fmt::format("roomfix_knocked_{}", getpid());
    fs::remove_all(folder);
    fs::create_directories(folder);
    const std::string session = (folder / "session").string(), fixes = (folder / "fixes.jsonl").string(), figures = (folder / "figures.json").string();
    constexpr int frames = 40, knocked_from = 15;
    constexpr std::uint64_t seed = 4;
    ASSERT_EQ(call(fmt::format("simulate li2014 -o {} --duration {} --seed {}", session, 0.1 * frames, seed)).code, 0);
    const auto watch = [&] {
        const Outcome replayed = call(fmt::format("replay {} --fixes {}", session, fixes));
        EXPECT_EQ(replayed.code, 0) << replayed.text;
        EXPECT_EQ(call(fmt::format("evaluate {} --truth {}/truth.csv --symmetry-deg 90 --json {}", fixes, session, figures)).code, 0);
        return replayed.text;
    };
    const std::string undisturbed = watch();
    EXPECT_EQ(undisturbed.find("(moved)"), std::string::npos) << undisturbed;

    const Scenario scenario = li2014_scenario(seed);
    ScenarioRenderer knocked(scenario, 0, seed, radians(0.8));
    LumaImage picture;
    for (int i = knocked_from; i < frames; ++i) {
        knocked.render(i / scenario.frame_rate, static_cast<std::uint64_t>(i), picture);
        const auto file = fs::path(session) / "frames" / scenario.cameras[0].id / fmt::format("{:012}.jpg", 100'000'000LL * i);
        ASSERT_TRUE(fs::exists(file)) << file;
        ASSERT_TRUE(save_luma(file, picture));
    }
    const std::string disturbed = watch();
    EXPECT_NE(disturbed.find(fmt::format("camera {} (moved): its picture lies", scenario.cameras[0].id)), std::string::npos) << disturbed;
    EXPECT_EQ(disturbed.find("camera " + scenario.cameras[1].id + " (moved)"), std::string::npos) << disturbed;
    std::ifstream file(figures);
    const auto report = nlohmann::json::parse(file);
    EXPECT_GE(report["all"]["position"]["count"], frames - 2);
    EXPECT_LT(report["all"]["position"]["rmse"], 0.01);
    EXPECT_LT(report["all"]["nees"]["mean"], 2.0);

    // Whoever calibrates it where it is now must not forget the background, or its pictures would be turned back to where it was.
    const std::string camera = scenario.cameras[0].id;
    const auto calibrated = [&](int frame) {
        return call(
            fmt::format("calibrate floor {0}/site.yaml --camera {1} --no-grid --picture {0}/frames/{1}/{2:012}.jpg", session, camera, 100'000'000LL * frame));
    };
    expect_says(calibrated(frames - 1), 0, "take a new background");
    const Outcome before = calibrated(0);
    EXPECT_EQ(before.text.find("take a new background"), std::string::npos) << before.text;
    fs::remove_all(folder);
}

}  // namespace
}  // namespace roomfix
