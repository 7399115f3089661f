// The tracker's consistency at full length: 200 drives for each set of senses.
#include <fmt/format.h>

#include <cstdlib>

#include "roomfix/evaluate/tracker_experiment.hpp"

int main(int argc, char** argv) {
    using namespace roomfix;
    const int runs = argc > 1 ? std::atoi(argv[1]) : 200;
    fmt::print("{:22} {:>8} {:>15} {:>8} {:>8} {:>6} {:>9} {:>6} {:>5}\n", "senses", "NEES", "95 % band", "rmse mm", "bound", "ratio", "yaw mrad", "ratio", "lost");
    for (const auto& [name, senses] : all_senses()) {
        const ConsistencyResult r = measure_consistency(name, senses, runs, 1);
        fmt::print("{:22} {:8.2f} {:>15} {:8.1f} {:8.1f} {:6.2f} {:9.2f} {:6.2f} {:>5}\n", r.name, r.nees, fmt::format("{:.2f}-{:.2f}", r.nees_low, r.nees_high),
                   1e3 * r.rmse, 1e3 * r.bound, r.rmse / r.bound, 1e3 * r.yaw_rmse, r.yaw_rmse / r.yaw_bound, r.lost);
    }
    fmt::print("true place inside the 95 % ellipse after 10 s on odometry alone (1 % scale, 1 deg/s drift): {:.1f} %\n",
               100 * blind_coverage(runs, 1, 0.01, radians(1.0)));
    return 0;
}
