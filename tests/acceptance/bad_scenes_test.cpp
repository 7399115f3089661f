// Scenes that go wrong in front of a fixed camera, replayed and set beside their truth: nothing is lost that is in plain view, and nothing is
// stated that is not so.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>

#include "acceptance/program.hpp"
#include "roomfix/evaluate/truth.hpp"
#include "roomfix/simulate/write_session.hpp"

namespace roomfix {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// The first aisle with its camera, without robots.
Scenario aisle(std::uint64_t seed, double frame_rate) {
    Scenario scenario = li2014_scenario(seed);
    scenario.cameras.resize(1);
    scenario.site.cameras.resize(1);
    scenario.robots.clear();
    scenario.site.robots.clear();
    scenario.frame_rate = frame_rate;
    return scenario;
}

ScenarioRobot robot(const std::string& id, const Shape& shape, const std::vector<Eigen::Vector2d>& path, double speed = 0.25, double start = 0) {
    ScenarioRobot made;
    made.robot = {id, shape};
    made.path = path;
    made.speed = speed;
    made.start = start;
    made.look.arms = false;
    return made;
}

void add(Scenario& scenario, const ScenarioRobot& robot) {
    scenario.robots.push_back(robot);
    scenario.site.robots.push_back(robot.robot);
}

const Shape small_box = Box{0.46, 0.34, 0.35}, tall_box = Box{0.40, 0.40, 0.70}, person = Cylinder{0.45, 1.75};
const std::vector<Eigen::Vector2d> round_trip = {{5.3, 5.45}, {7.2, 5.45}, {7.2, 5.95}, {5.3, 5.95}};

/// A session of the scenario, and what `replay` and `evaluate` say of it.
struct Replayed {
    fs::path folder;
    Outcome outcome;
    std::vector<json> fixes;
    json report;
};

fs::path write(const std::string& name, const Scenario& scenario, double duration, std::uint64_t seed) {
    const fs::path folder = fs::path(testing::TempDir()) / ("bad-scenes-" + name);
    fs::remove_all(folder);
    fs::create_directories(folder);
    const auto written = write_session(scenario, folder, {.duration = duration, .background_frames = 10, .seed = seed});
    EXPECT_TRUE(written) << written.error().message;
    return folder;
}

Replayed replay(const fs::path& folder) {
    Replayed replayed;
    replayed.folder = folder;
    replayed.outcome = call(fmt::format("replay {0} --fixes {0}/fixes.jsonl", folder.string()));
    EXPECT_EQ(replayed.outcome.code, 0) << replayed.outcome.text;
    std::ifstream file(folder / "fixes.jsonl");
    for (std::string line; std::getline(file, line);) replayed.fixes.push_back(json::parse(line));
    EXPECT_EQ(call(fmt::format("evaluate {0}/fixes.jsonl --truth {0}/truth.csv --json {0}/report.json", folder.string())).code, 0);
    std::ifstream report(folder / "report.json");
    replayed.report = json::parse(report);
    return replayed;
}

TEST(BadScenes, MoreRobotsInViewThanTheSiteHas) {
    Scenario scenario = aisle(31, 5);
    add(scenario, robot("r1", tall_box, round_trip));
    scenario.others.push_back(robot("", small_box, round_trip, 0.25, 2.4));
    scenario.others.push_back(robot("", Box{0.8, 0.5, 0.6}, {{7.6, 5.7}}));
    const Replayed replayed = replay(write("too-many", scenario, 10, 31));
    std::puts(replayed.report.dump(1).c_str());
}

TEST(BadScenes, ARobotIsCarriedAway) {
    Scenario scenario = aisle(32, 5);
    add(scenario, robot("r1", small_box, round_trip));
    add(scenario, robot("r2", tall_box, {{7.4, 5.7}}));
    scenario.robots[0].until = 5;
    const Replayed replayed = replay(write("carried", scenario, 12, 32));
    std::puts(replayed.report.dump(1).c_str());
}

TEST(BadScenes, TwoRobotsTouchForAMinute) {
    Scenario scenario = aisle(33, 4);
    add(scenario, robot("r1", small_box, {{5.20, 5.60}, {7.0, 5.60}}));
    add(scenario, robot("r2", tall_box, {{6.84, 5.62}}));
    scenario.robots[0].pause_from = 1.2 / 0.25;  // its front at r2's back
    scenario.robots[0].pause_to = 65;
    const Replayed replayed = replay(write("touching", scenario, 66, 33));
    std::puts(replayed.report.dump(1).c_str());
}

TEST(BadScenes, ACameraStutters) {
    Scenario scenario = aisle(34, 10);
    add(scenario, robot("r1", small_box, round_trip));
    const fs::path folder = write("stutter", scenario, 10, 34);
    std::puts(replay(folder).report.dump(1).c_str());
}

TEST(BadScenes, APersonStandsStillForTenMinutes) {
    Scenario scenario = aisle(35, 1);
    add(scenario, robot("r1", small_box, round_trip, 0.1));
    scenario.others.push_back(robot("", person, {{7.6, 5.7}}));
    const Replayed replayed = replay(write("person", scenario, 600, 35));
    std::puts(replayed.report.dump(1).c_str());
}

}  // namespace
}  // namespace roomfix
