// The accuracy figures of docs/li2014.md at full length: many seeds, hidden robots, light changes, consistency.
#include <fmt/format.h>

#include "roomfix/evaluate/consistency.hpp"
#include "roomfix/evaluate/li2014_experiment.hpp"

namespace {

using namespace roomfix;

void report(const char* what, const Li2014Options& options) {
    const auto result = run_li2014(options);
    if (!result) {
        fmt::print("{}: {}\n", what, result.error().message);
        return;
    }
    const Summary position = summarise(result->position_errors());
    const Summary yaw = summarise(result->yaw_errors());
    fmt::print("{:<34} {:4} fixes {:3} lost  position mean {:5.2f} median {:5.2f} p95 {:5.2f} max {:6.2f} cm  yaw rms {:5.2f} deg  mean NEES {:.2f}\n", what,
               position.count, result->lost(), 100 * position.mean, 100 * position.median, 100 * position.p95, 100 * position.max, degrees(yaw.rms),
               result->mean_nees());
    std::fflush(stdout);
}

}  // namespace

int main() {
    report("15 points, 3 seeds", {.seed = 1, .seeds = 3, .published = false});
    report("15 points, 3 seeds, true lenses", {.seed = 1, .seeds = 3, .published = false, .board = {.shots = 0}});
    report("15 points, seeds 101-103", {.seed = 101, .seeds = 3, .published = false});
    report("light 0.85", {.seed = 1, .seeds = 3, .light = 0.85, .published = false, .board = {.shots = 0}});
    report("light 1.15", {.seed = 1, .seeds = 3, .light = 1.15, .published = false, .board = {.shots = 0}});
    report("30 % hidden", {.seed = 1, .seeds = 3, .hidden = 0.3, .published = false, .board = {.shots = 0}});
    report("consistency, 600 fixes, 20 sites", {.seed = 1001, .seeds = 20, .fixes_per_point = 2, .scatter = true, .published = false, .board = {.shots = 0}});
}
