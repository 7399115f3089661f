#include <fmt/format.h>

#include <filesystem>
#include <memory>

#include "commands.hpp"
#include "roomfix/site/load_site.hpp"
#include "terminal.hpp"

namespace roomfix {
namespace {

int check(const std::string& file) {
    const LoadedSite loaded = inspect_site(file);
    int errors = 0;
    for (const Problem& problem : loaded.problems) {
        fmt::print("{}\n", problem_text(file, problem));
        errors += problem.fatal;
    }
    if (errors > 0) {
        complain(fmt::format("{}: {} error{}", file, errors, errors == 1 ? "" : "s"));
        return bad_input;
    }
    for (const SiteCamera& camera : loaded.site.cameras) {
        std::error_code failure;
        const std::string path = resolved_path(loaded.site, camera.source);
        if (path.find("://") == std::string::npos && !std::filesystem::exists(path, failure)) {
            fmt::print("{}: note: cameras.{}.source: {} does not exist (yet)\n", file, camera.id, path);
        }
    }
    say(fmt::format("{}: {} camera(s), {} robot(s): ready", file, loaded.site.cameras.size(), loaded.site.robots.size()));
    return done;
}

}  // namespace

void add_check(Command& program) {
    Command command = program.add_command("check", "everything wrong with a site file, with line and column");
    auto file = std::make_shared<std::string>();
    command.option("SITE", *file, "site file").required();
    command.footer("Example: roomfix check examples/hall/site.yaml");
    command.on_run([=] { return check(*file); });
}

}  // namespace roomfix
