// The tracker's consistency at full length: 200 drives for each set of senses.
#include <fmt/format.h>

#include <cstdio>
#include <cstdlib>

#include "roomfix/evaluate/identity_experiment.hpp"
#include "roomfix/evaluate/tracker_experiment.hpp"

int main(int argc, char** argv) {
    using namespace roomfix;
    std::setvbuf(stdout, nullptr, _IOLBF, BUFSIZ);  // it takes long: each line as it comes, into a file, too
    const CrossingResult with = simulate_crossings(100, true, 1);
    const CrossingResult without = simulate_crossings(100, false, 1);
    for (const auto& [name, r] : {std::pair{"with", with}, std::pair{"without", without}}) {
        fmt::print("100 crossings of two look-alikes {} odometry: {} switches, {} of them flagged; {} false alarms, {} lost\n", name, r.switches, r.flagged,
                   r.false_alarms, r.lost);
    }
    for (const bool odometry : {true, false}) {
        double overlap = 0;
        const CrossingResult r = render_crossings(100, odometry, 1, overlap);
        fmt::print("100 rendered crossings {} odometry, {:.0f} % hidden: {} switches, {} of them flagged; {} false alarms, {} lost\n",
                   odometry ? "with" : "without", 100 * overlap, r.switches, r.flagged, r.false_alarms, r.lost);
    }
    const CornerChoiceResult corners = choose_among_corners(500, 1);
    fmt::print("four like corners: right at once in {:.1f} %, after 2 m in {:.1f} % of {} runs\n", 100.0 * corners.right_at_once / corners.runs,
               100.0 * corners.right / corners.runs, corners.runs);
    const KidnappingResult kidnapped = simulate_kidnappings(200, 1);
    fmt::print("kidnapped: {} of {} found within 2 s, the last after {:.2f} s\n", kidnapped.found, kidnapped.runs, kidnapped.longest);
    const int runs = argc > 1 ? std::atoi(argv[1]) : 200;
    fmt::print("{:22} {:>8} {:>15} {:>8} {:>8} {:>6} {:>9} {:>6} {:>5}\n", "senses", "NEES", "95 % band", "rmse mm", "bound", "ratio", "yaw mrad", "ratio",
               "lost");
    for (const bool smoothed : {false, true}) {
        if (smoothed) fmt::print("smoothed after the drive; NEES in its middle; the bound is that of what was known at the time\n");
        for (const auto& [name, senses] : all_senses()) {
            const ConsistencyResult r = measure_consistency(name, senses, runs, 1, {}, smoothed);
            fmt::print("{:22} {:8.2f} {:>15} {:8.1f} {:8.1f} {:6.2f} {:9.2f} {:6.2f} {:>5}\n", r.name, r.nees,
                       fmt::format("{:.2f}-{:.2f}", r.nees_low, r.nees_high), 1e3 * r.rmse, 1e3 * r.bound, r.rmse / r.bound, 1e3 * r.yaw_rmse,
                       r.yaw_rmse / r.yaw_bound, r.lost);
        }
    }
    fmt::print("true place inside the 95 % ellipse after 10 s on odometry alone (1 % scale, 1 deg/s drift): {:.1f} %\n",
               100 * blind_coverage(runs, 1, 0.01, radians(1.0)));
    return 0;
}
