#include <fmt/format.h>

#include <filesystem>
#include <iostream>
#include <memory>
#include <utility>

#include "commands.hpp"
#include "roomfix/evaluate/recorded_fixes.hpp"
#include "roomfix/evaluate/truth.hpp"
#include "roomfix/pipeline/session_export.hpp"
#include "roomfix/site/load_site.hpp"
#include "terminal.hpp"

namespace roomfix {
namespace {

struct Arguments {
    std::string session, fixes, mcap, bag;
};

/// The fixes that were named, or those of the session if it has some.
Result<std::vector<Fix>> fixes_of(const Arguments& arguments, const Site& site) {
    const std::string own = (site.folder / "fixes.jsonl").string();
    if (arguments.fixes.empty() && !std::filesystem::exists(own)) {
        say(fmt::format("{} does not exist: no poses are exported; 'roomfix replay {} --fixes {}' makes it", own, arguments.session, own));
        return std::vector<Fix>();
    }
    const std::string file = arguments.fixes.empty() ? own : arguments.fixes;
    auto recorded = load_fixes(file);
    if (!recorded) return recorded.error();
    for (const std::string& problem : recorded->problems) say(file + ", " + problem);
    return std::move(recorded->fixes);
}

Result<std::vector<TruePlace>> truth_of(const Site& site) {
    std::vector<TruePlace> places;
    const std::string file = (site.folder / "truth.csv").string();
    if (!std::filesystem::exists(file)) return places;
    const auto truth = load_truth(file);
    if (!truth) return truth.error();
    for (const auto& [robot, poses] : *truth) {
        for (const StampedPose& pose : poses) places.push_back({pose.time, robot, pose.pose, pose.yaw_known});
    }
    return places;
}

struct Session {
    Site site;
    SessionRecords records;
};

Result<Session> load(const Arguments& arguments) {
    auto site = load_session(arguments.session);
    if (!site) return Error{"the session's site file cannot be used:\n" + site.error().message};
    auto fixes = fixes_of(arguments, *site);
    if (!fixes) return fixes.error();
    auto truth = truth_of(*site);
    if (!truth) return truth.error();
    return Session{std::move(*site), {site_file_of(arguments.session), std::move(*fixes), std::move(*truth)}};
}

int run_export(const Arguments& arguments) {
    const auto session = load(arguments);
    if (!session) {
        complain(session.error().message);
        return bad_input;
    }
    const auto progress = progress_bar("exporting");
    const auto report = arguments.bag.empty() ? export_mcap(session->site, session->records, arguments.mcap, progress)
                                              : export_bag(session->site, session->records, arguments.bag, progress);
    if (!report) {
        complain(report.error().message);
        return failed;
    }
    for (const std::string& note : report->notes) say(note);
    for (const RecordedTopic& topic : report->contents.topics) std::cout << fmt::format("{}  {}  {} messages\n", topic.name, topic.type, topic.messages);
    return done;
}

}  // namespace

void add_export(Command& program) {
    Command command = program.add_command("export", "a session as ROS 2 messages in one MCAP file, or as a folder that rosbag2 plays");
    auto arguments = std::make_shared<Arguments>();
    command.option("SESSION", arguments->session, "session folder").required();
    command.option("--fixes", arguments->fixes, "file of fixes (default: the session's fixes.jsonl)");
    Command file = command.add_choice("where to");
    file.option("--mcap", arguments->mcap, "file to write");
    file.option("--bag", arguments->bag, "folder to make, which must not exist yet");
    command.footer("Example: roomfix export session --mcap session.mcap");
    command.on_run([=] { return run_export(*arguments); });
}

}  // namespace roomfix
