#include <fmt/format.h>

#include <memory>

#include "commands.hpp"
#include "roomfix/evaluate/li2014_experiment.hpp"
#include "terminal.hpp"

namespace roomfix {
namespace {

struct Arguments {
    std::vector<std::string> papers = {"li2014"};
    Li2014Options li2014;
};

int reproduce(const Arguments& arguments) {
    for (const std::string& paper : arguments.papers) {
        const auto report = run_li2014(arguments.li2014, progress_bar("reproducing " + paper));
        if (!report) {
            complain(report.error().message);
            return failed;
        }
        fmt::print("{}", li2014_table(*report));
    }
    return done;
}

}  // namespace

void add_reproduce(CLI::App& app, int& exit_code) {
    auto* command = app.add_subcommand("reproduce", "a paper's experiment: printed, its method as published, ours, the bound");
    auto arguments = std::make_shared<Arguments>();
    command->add_option("PAPER", arguments->papers, "li2014")->check(CLI::IsMember({"li2014"}));
    command->add_option("--seed", arguments->li2014.seed, "first seed")->capture_default_str();
    command->add_option("--seeds", arguments->li2014.seeds, "how many seeds, each with its own noise, clicks and headings")
        ->capture_default_str()
        ->check(CLI::Range(1, 1000));
    command->add_option("--fixes", arguments->li2014.fixes_per_point, "fixes per test point and seed")->capture_default_str()->check(CLI::Range(1, 10000));
    command->add_option("--hidden", arguments->li2014.hidden, "part of the robot hidden behind something, 0..0.8")->check(CLI::Range(0.0, 0.8));
    command->add_option("--light", arguments->li2014.light, "light against the background's, such as 0.85")->check(CLI::Range(0.2, 3.0));
    command->add_flag("--scatter", arguments->li2014.scatter, "places around the test points instead of on them");
    command->footer("Example: roomfix reproduce li2014 --seeds 3");
    command->callback([=, &exit_code] { exit_code = reproduce(*arguments); });
}

}  // namespace roomfix
