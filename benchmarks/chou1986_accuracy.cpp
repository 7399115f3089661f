// The room corner's accuracy figures at full length; docs/chou1986.md lists the goals.
#include <fmt/format.h>

#include <utility>

#include "roomfix/evaluate/chou1986_experiment.hpp"

int main() {
    using namespace roomfix;
    const std::pair<const char*, BoardPictures> lenses[] = {
        {"from pictures of a board", {}}, {"from pictures of a flat board", {.flat = true}}, {"known exactly", {.shots = 0}}};
    for (const auto& [lens, board] : lenses) {
        const auto report = run_chou1986({.seed = 1, .seeds = 10, .published = board.shots > 0 && !board.flat, .board = board});
        fmt::print("\n== chou1986, lens {} (goals: mean 0.05 %, largest 0.3 %, rotation 0.02 deg, 1.5 x the bound)\n{}", lens,
                   report ? chou1986_table(*report) : report.error().message);
        std::fflush(stdout);
    }
    std::fflush(stdout);
    for (const bool hard : {false, true}) {
        const Walls walls = hard ? Walls::hard : Walls::plain;
        const char* kind = hard ? "furnished rooms whose walls are hard to tell apart" : "furnished rooms";
        const ClutterReport rooms = run_cluttered(1000, 11, walls);
        fmt::print("== {}: {} of {} pictures show a corner; of these {:.1f} % within 1 % (goal 95), {:.1f} % no fix; wrong {} of {} ({:.2f} %, goal 0.5); {}\n",
                   kind, rooms.visible, rooms.pictures, 100.0 * rooms.good / rooms.visible, 100.0 * rooms.none / rooms.visible, rooms.wrong, rooms.pictures,
                   100.0 * rooms.wrong / rooms.pictures, rooms.first_wrong);
        std::fflush(stdout);
        fmt::print("== {}, no corner in the picture: {} fixes in 1000 (goal 0)\n", kind, run_cornerless(1000, 12, walls));
        std::fflush(stdout);
    }
}
