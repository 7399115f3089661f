// Cameras that expose their rows one after another: what it is worth to state that, by the program's own commands.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "acceptance/program.hpp"

namespace roomfix {
namespace {

namespace fs = std::filesystem;

struct Figures {
    double rmse = 0;  // m
    double nees = 0;  // per unknown
    double yaw = 0;   // rad, the median
};

class RollingShutter : public ::testing::Test {
protected:
    void SetUp() override { fs::create_directories(folder); }
    void TearDown() override { fs::remove_all(folder); }

    /// Rows are read out within 30 ms while the robot drives 1.2 m/s.
    void simulate(const std::string& scenario, double seconds) const {
        const Outcome made = call(fmt::format("simulate {} --duration {} --readout 0.03 --speed 1.2 -o {}", scenario, seconds, (folder / "session").string()));
        ASSERT_EQ(made.code, 0) << made.text;
    }
    /// As if nobody had said that the rows come one after another.
    void leave_readout_out() const {
        std::ifstream before(folder / "session/site.yaml");
        std::string text;
        int left_out = 0;
        for (std::string line; std::getline(before, line);) {
            const bool states_it = line.find("readout:") != line.npos;
            left_out += states_it;
            if (!states_it) text += line + "\n";
        }
        ASSERT_GT(left_out, 0);
        std::ofstream(folder / "session/site.yaml") << text;
    }
    Figures evaluated() const {
        const std::string fixes = (folder / "fixes.jsonl").string(), json = (folder / "figures.json").string();
        const Outcome replayed = call(fmt::format("replay {} --fixes {}", (folder / "session").string(), fixes));
        EXPECT_EQ(replayed.code, 0) << replayed.text;
        const Outcome evaluated = call(fmt::format("evaluate {} --truth {} --json {}", fixes, (folder / "session/truth.csv").string(), json));
        EXPECT_EQ(evaluated.code, 0) << evaluated.text;
        std::ifstream stream(json);
        const auto all = nlohmann::json::parse(stream).at("all");
        return {all.at("position").at("rmse"), all.at("nees").at("mean"), all.at("yaw").at("median")};
    }

    fs::path folder = fs::temp_directory_path() / fmt::format("roomfix_rolling_{}", getpid());
};

TEST_F(RollingShutter, AFixedCameraSeesAFastRobotWhereItIs) {
    ASSERT_NO_FATAL_FAILURE(simulate("li2014", 3.5));
    const Figures stated = evaluated();
    ASSERT_NO_FATAL_FAILURE(leave_readout_out());
    const Figures not_stated = evaluated();
    std::cout << fmt::format("stated: {:.1f} mm, NEES {:.2f}; not stated: {:.1f} mm, NEES {:.2f}\n", 1e3 * stated.rmse, stated.nees, 1e3 * not_stated.rmse,
                             not_stated.nees);
    EXPECT_LT(stated.rmse, 0.8 * not_stated.rmse);
    EXPECT_LT(stated.nees, 2);
    EXPECT_GT(not_stated.nees, 1.5 * stated.nees);
}

TEST_F(RollingShutter, ACameraThatLooksUpKnowsWhereItIs) {
    ASSERT_NO_FATAL_FAILURE(simulate("kim2011-fast", 8));
    const Figures stated = evaluated();
    ASSERT_NO_FATAL_FAILURE(leave_readout_out());
    const Figures not_stated = evaluated();
    std::cout << fmt::format("stated: {:.1f} mm, NEES {:.2f}; not stated: {:.1f} mm, NEES {:.2f}\n", 1e3 * stated.rmse, stated.nees, 1e3 * not_stated.rmse,
                             not_stated.nees);
    EXPECT_LT(stated.rmse, 0.8 * not_stated.rmse);
    EXPECT_LT(stated.nees, 2);
    EXPECT_GT(not_stated.nees, 1.5 * stated.nees);
}

}  // namespace
}  // namespace roomfix
