// Runs benchmarks several times, interleaved, and remembers each one's median for the ratios that are printed last.
#pragma once

#include <benchmark/benchmark.h>

#include <map>
#include <string>
#include <vector>

namespace roomfix {

class Medians : public benchmark::ConsoleReporter {
public:
    /// Seven repetitions in random order, at least 0.2 s each, unless the arguments say otherwise.
    void run(int argc, char** argv) {
        std::vector<char*> arguments(argv, argv + argc);
        std::string options[] = {"--benchmark_repetitions=7", "--benchmark_report_aggregates_only=true", "--benchmark_enable_random_interleaving=true",
                                 "--benchmark_min_time=0.2"};
        for (std::string& option : options) arguments.insert(arguments.begin() + 1, option.data());
        int count = static_cast<int>(arguments.size());
        benchmark::Initialize(&count, arguments.data());
        benchmark::RunSpecifiedBenchmarks(this);
    }
    void ReportRuns(const std::vector<Run>& runs) override {
        ConsoleReporter::ReportRuns(runs);
        for (const Run& run : runs) {
            if (run.run_type != Run::RT_Aggregate || run.aggregate_name != "median" || run.error_occurred) continue;
            const std::string& size = run.run_name.args;
            times[run.run_name.function_name + (size.empty() ? "" : "/" + size)] = run.GetAdjustedCPUTime();
        }
    }
    std::map<std::string, double> times;  // by name, or name/argument; in the benchmark's unit
};

}  // namespace roomfix
