#include <fmt/format.h>

#include <fstream>
#include <memory>

#include "commands.hpp"
#include "roomfix/evaluate/chou1986_experiment.hpp"
#include "roomfix/evaluate/kim2011_experiment.hpp"
#include "roomfix/evaluate/li2014_experiment.hpp"
#include "terminal.hpp"

namespace roomfix {
namespace {

struct Arguments {
    std::vector<std::string> papers;
    Li2014Options li2014;
    Kim2011Options kim2011;
    Chou1986Options chou1986;
    std::string plot;
    std::uint64_t seed = 1;
    int seeds = 3;
    double tilt_deg = 0;
    BoardPictures board;
};

/// Prints one paper's table.
Result<void> reproduce_paper(const std::string& paper, const Arguments& arguments) {
    const auto progress = progress_bar("reproducing " + paper);
    if (paper == "li2014") {
        const auto report = run_li2014(arguments.li2014, progress);
        if (!report) return report.error();
        fmt::print("{}", li2014_table(*report));
        return {};
    }
    if (paper == "chou1986") {
        const auto report = run_chou1986(arguments.chou1986, progress);
        if (!report) return report.error();
        fmt::print("{}", chou1986_table(*report));
        if (arguments.plot.empty()) return {};
        std::ofstream file(arguments.plot, std::ios::binary);
        file << svg_of(chou1986_error_study());
        if (!file.flush()) return Error{fmt::format("{}: cannot be written: check that the folder exists", arguments.plot)};
        say(arguments.plot + ": the paper's error study");
        return {};
    }
    const auto report = run_kim2011(arguments.kim2011, progress);
    if (!report) return report.error();
    fmt::print("{}", kim2011_table(*report));
    return {};
}

int reproduce(Arguments arguments) {
    if (arguments.papers.empty()) arguments.papers = {"li2014", "kim2011", "chou1986"};
    arguments.li2014.seed = arguments.kim2011.seed = arguments.chou1986.seed = arguments.seed;
    arguments.li2014.seeds = arguments.kim2011.seeds = arguments.chou1986.seeds = arguments.seeds;
    arguments.li2014.board = arguments.kim2011.board = arguments.chou1986.board = arguments.board;
    arguments.kim2011.tilt = radians(arguments.tilt_deg);
    for (const std::string& paper : arguments.papers) {
        if (const auto done_one = reproduce_paper(paper, arguments); !done_one) {
            complain(done_one.error().message);
            return failed;
        }
    }
    return done;
}

}  // namespace

void add_reproduce(Command& program) {
    Command command = program.add_command("reproduce", "a paper's experiment: printed, its method as published, ours, the bound");
    auto arguments = std::make_shared<Arguments>();
    command.option("PAPER", arguments->papers, "li2014, kim2011, chou1986 (default: all)").one_of({"li2014", "kim2011", "chou1986"});
    command.option("--seed", arguments->seed, "first seed").show_default();
    command.option("--seeds", arguments->seeds, "how many seeds, each with its own noise, clicks and headings").show_default().range(1, 1000);
    command
        .option("--board-shots", arguments->board.shots,
                "rendered pictures of a board from which each lens is calibrated, before floor and mount are; 0: the true lens")
        .show_default()
        .range(0, 1000);
    command.flag("--flat-board", arguments->board.flat, "the board is printed exactly, flat and still instead of glued and held as people do it");
    command.option("--fixes", arguments->li2014.fixes_per_point, "li2014: fixes per test point and seed").show_default().range(1, 10000);
    command.option("--hidden", arguments->li2014.hidden, "li2014: part of the robot hidden behind something, 0..0.8").range(0.0, 0.8);
    command.option("--light", arguments->li2014.light, "li2014: light against the background's, such as 0.85").range(0.2, 3.0);
    command.flag("--scatter", arguments->li2014.scatter, "li2014: places around the test points instead of on them");
    command.option("--samples", arguments->kim2011.samples, "kim2011: samples per position and seed").show_default().range(1, 100000);
    command.option("--tilt-deg", arguments->tilt_deg, "kim2011: true tilt of the camera; a turn on the spot calibrates it").range(0.0, 5.0);
    command.option("--late", arguments->kim2011.late, "kim2011: part of the ranges that come around a corner, 0..1").range(0.0, 1.0);
    command.option("--plot", arguments->plot, "chou1986: SVG file for the paper's error study");
    command.footer("Example: roomfix reproduce kim2011 --tilt-deg 0.5");
    command.on_run([=] { return reproduce(*arguments); });
}

}  // namespace roomfix
