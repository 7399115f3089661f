// What the demo shows, beside its own truth.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <utility>

#include "acceptance/program.hpp"

namespace roomfix {
namespace {

TEST(Demo, ItsRobotsAreWhereItsTruthSays) {
    namespace fs = std::filesystem;
    const fs::path folder = fs::temp_directory_path() / fmt::format("roomfix_demo_truth_{}", getpid());
    fs::remove_all(folder);
    fs::create_directories(folder);
    const std::string session = (folder / "session").string(), fixes = (folder / "fixes.jsonl").string(), figures = (folder / "figures.json").string();
    ASSERT_EQ(call(fmt::format("simulate demo -o {} --duration 3 --seed 11", session)).code, 0);
    ASSERT_EQ(call(fmt::format("replay {} --fixes {}", session, fixes)).code, 0);
    ASSERT_EQ(call(fmt::format("evaluate {} --truth {}/truth.csv --json {}", fixes, session, figures)).code, 0);
    std::ifstream file(figures);
    const auto report = nlohmann::json::parse(file);
    EXPECT_EQ(report["identity_switches"], report["flagged_switches"]) << "a wrong name that was not said to be doubtful";
    EXPECT_LT(report["all"]["position"]["median"], 0.03);
    for (const auto& robot : report["robots"]) {  // a1 and a2 look alike: until they have moved, each may be the other
        if (robot["name"] == "a1" || robot["name"] == "a2") continue;
        EXPECT_LT(robot["position"]["rmse"], 0.06) << robot["name"];
        EXPECT_LT(robot["nees"]["mean"], 2.0) << robot["name"];
    }
    std::ifstream given(fixes);
    std::set<std::pair<std::string, double>> coasting;
    for (std::string line; std::getline(given, line);) {
        const auto fix = nlohmann::json::parse(line);
        if (fix["status"] != "coasting" || fix["robot"].is_null()) continue;
        EXPECT_TRUE(coasting.emplace(fix["robot"], fix["time"]).second) << "given twice: " << line;
    }
    fs::remove_all(folder);
}

TEST(Demo, ATruthThatCannotBeWrittenIsSaidBeforeAnythingIsRendered) {
    expect_says(call("demo --port 0 --seconds 0.2 --truth /nowhere/at/all/truth.csv"), 2, "/nowhere/at/all/truth.csv: cannot be written");
}

}  // namespace
}  // namespace roomfix
