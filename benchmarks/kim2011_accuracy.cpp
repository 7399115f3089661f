// The ceiling landmark's accuracy figures at full length; docs/kim2011.md lists the goals.
#include <fmt/format.h>

#include "roomfix/evaluate/ceiling_robustness.hpp"
#include "roomfix/evaluate/kim2011_experiment.hpp"

int main() {
    using namespace roomfix;
    const auto table = [](const char* title, const Kim2011Options& options) {
        const auto report = run_kim2011(options);
        fmt::print("\n== {}\n{}", title, report ? kim2011_table(*report) : report.error().message);
        std::fflush(stdout);
    };
    table("level camera (goals: 0.20 cm, yaw 0.25 deg, 1.3 x the bound)", {});
    table("the same, lens and mount known exactly", {.baselines = false, .board = {.shots = 0}});
    table("10 % of the ranges late (goal: changes ours by less than 10 %)", {.late = 0.10});
    table("mount tilted by 0.5 deg, calibrated (goal: 0.5 cm)", {.seed = 601, .seeds = 40, .samples = 3, .tilt = radians(0.5)});
    const auto lamps = run_with_lamps(2000, 5);
    fmt::print("\n== lamps: {} of {} frames right ({:.2f} %, goal 99), {} wrong, {} none; {}\n", lamps.right, lamps.frames, 100.0 * lamps.right / lamps.frames,
               lamps.wrong, lamps.none, lamps.first_miss);
    const auto empty = run_without_landmark(10000, 6);
    fmt::print("== without a landmark: {} wrong fixes in {} frames (goal 0)\n", empty.wrong, empty.frames);
}
