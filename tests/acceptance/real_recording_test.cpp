// The real recording that comes with the project, by the program's own commands.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "acceptance/program.hpp"

namespace roomfix {
namespace {

// The method was made with this drive in sight, among others: that it still works is all that this says. docs/tracker.md has the figures.
TEST(RealRecording, ADriveThroughALabyrinthIsFoundFromGeometryAlone) {
    namespace fs = std::filesystem;
    const fs::path folder = fs::temp_directory_path() / fmt::format("roomfix_labyrinth_{}", getpid());
    fs::remove_all(folder);
    fs::create_directories(folder);
    const std::string session = std::string(ROOMFIX_SOURCE) + "/examples/labyrinth";
    const std::string fixes = (folder / "fixes.jsonl").string(), figures = (folder / "figures.json").string();
    const Outcome replayed = call(fmt::format("replay {} --fixes {}", session, fixes));
    ASSERT_EQ(replayed.code, 0) << replayed.text;
    ASSERT_EQ(call(fmt::format("evaluate {} --truth {}/truth.csv --json {}", fixes, session, figures)).code, 0);
    std::ifstream file(figures);
    const auto report = nlohmann::json::parse(file);
    EXPECT_LT(report["all"]["position"]["rmse"], 0.085) << "m";
    EXPECT_LT(report["all"]["nees"]["mean"], 1.6);
    EXPECT_GT(report["availability"], 0.86);  // the first seconds leave its front open
    fs::remove_all(folder);
}

}  // namespace
}  // namespace roomfix
