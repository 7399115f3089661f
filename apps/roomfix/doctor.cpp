#include <fmt/format.h>

#include <memory>

#include "commands.hpp"
#include "roomfix/pipeline/site_doctor.hpp"
#include "roomfix/site/load_site.hpp"
#include "terminal.hpp"

namespace roomfix {
namespace {

const char* word_of(Finding::Kind kind) {
    if (kind == Finding::Kind::fine) return "ok     ";
    return kind == Finding::Kind::note ? "note   " : "PROBLEM";
}

int doctor(const std::string& file) {
    const LoadedSite loaded = inspect_site(file);
    for (const Problem& problem : loaded.problems) fmt::print("{} {}\n", problem.fatal ? "PROBLEM" : "note   ", problem_text(file, problem));
    if (!loaded.usable()) {
        complain("the site file cannot be used: mend it first");
        return bad_input;
    }
    int problems = 0;
    examine(loaded.site, [&](const Finding& finding) {
        problems += finding.kind == Finding::Kind::problem;
        fmt::print("{} {}: {}\n", word_of(finding.kind), finding.what, finding.text);
        std::fflush(stdout);
    });
    say(problems == 0 ? "nothing is in the way of 'roomfix run'"
                      : fmt::format("{} to be mended", problems == 1 ? "one thing is" : fmt::format("{} things are", problems)));
    return problems == 0 ? done : failed;
}

}  // namespace

void add_doctor(Command& program) {
    Command command = program.add_command("doctor", "tries all that a site file names: cameras, senses, ports, brokers, databases, disks");
    auto site = std::make_shared<std::string>();
    command.option("SITE", *site, "site file").required();
    command.footer("Example: roomfix doctor site.yaml");
    command.on_run([=] { return doctor(*site); });
}

}  // namespace roomfix
