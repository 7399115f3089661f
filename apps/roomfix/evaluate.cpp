#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <iostream>
#include <memory>

#include "commands.hpp"
#include "roomfix/base/number.hpp"
#include "roomfix/base/worker_pool.hpp"
#include "roomfix/evaluate/error_report.hpp"
#include "roomfix/evaluate/tracking_bound.hpp"
#include "roomfix/pipeline/replay.hpp"
#include "roomfix/pipeline/sigma_advice.hpp"
#include "roomfix/site/load_site.hpp"
#include "run_site.hpp"
#include "terminal.hpp"

namespace roomfix {
namespace {

struct Arguments {
    std::string fixes, truth, report, json, tum, session, point;
    double symmetry_deg = 0;
    double cutoff = ReportOptions{}.cutoff;
};

/// Where the point that the truth is about sits on the robot, m. Its height does not matter: fixes are on the floor.
Result<Eigen::Vector2d> point_of(const std::string& text) {
    constexpr double farthest = 10;  // m
    if (text.empty()) return Eigen::Vector2d(Eigen::Vector2d::Zero());
    const auto numbers = parse_numbers(text);
    if (!numbers || numbers->size() != 3) {
        return Error{fmt::format("--point {}: write the point's x (forward), y (left) and z (up) on the robot in metres, such as 0.2,-0.05,0.4", text)};
    }
    for (const double number : *numbers) {
        if (std::abs(number) > farthest) return Error{fmt::format("--point {}: {} m is not on the robot; write metres, such as 0.2,-0.05,0.4", text, number)};
    }
    return Eigen::Vector2d((*numbers)[0], (*numbers)[1]);
}

/// One file per robot for its fixes and one for its truth.
bool write_tum(const std::filesystem::path& folder, const ErrorReport& report, const Truth& truth) {
    std::error_code failure;
    std::filesystem::create_directories(folder, failure);
    std::map<std::string, std::vector<StampedPose>> fixes;
    for (const JudgedFix& f : report.fixes) fixes[f.robot].push_back({f.time, f.fix, f.fix_has_yaw});
    for (const auto& [robot, poses] : fixes) {
        if (!write_file(folder / (robot + ".tum"), tum_text(poses))) return false;
    }
    for (const auto& [robot, poses] : truth) {
        if (!write_file(folder / (robot + "-truth.tum"), tum_text(poses))) return false;
    }
    return true;
}

/// What a session says beside its fixes, once its sources were observed again.
struct SessionFindings {
    std::vector<std::optional<Eigen::Matrix3d>> bounds;  // what the best tracker could have made of it
    std::vector<SigmaAdvice> advice;
};

Result<SessionFindings> look_into(const std::filesystem::path& session, const std::vector<Fix>& fixes, const Truth& truth, const Eigen::Vector2d& point) {
    const auto site = load_session(session);
    if (!site) return site.error();
    ReplaySettings settings;
    settings.threads = hardware_threads();
    settings.keep_history = true;
    settings.stop = &stop_requested();
    settings.progress = progress_bar("observing again");
    settings.listener = background_on_terminal();
    const auto replayed = replay(*site, settings);
    if (!replayed) return replayed.error();
    const Tracker& tracker = replayed->tracker->tracker();
    return SessionFindings{tracking_bounds(tracker, fixes, truth, progress_bar("finding the bound"), point), sigma_advice(tracker)};
}

int evaluate(const Arguments& arguments) {
    const auto recorded = load_fixes(arguments.fixes);
    const auto truth = load_truth(arguments.truth);
    const auto point = point_of(arguments.point);
    if (!recorded || !truth || !point) {
        if (!recorded) complain(recorded.error().message);
        if (!truth) complain(truth.error().message);
        if (!point) complain(point.error().message);
        return bad_input;
    }
    for (const std::string& problem : recorded->problems) say(arguments.fixes + ", " + problem);
    SessionFindings session;
    if (!arguments.session.empty()) {
        auto found = look_into(arguments.session, recorded->fixes, *truth, *point);
        if (!found) {
            complain(found.error().message);
            return bad_input;
        }
        session = std::move(*found);
    }
    const ErrorReport report =
        judge(*recorded, *truth, {.symmetry = radians(arguments.symmetry_deg), .cutoff = arguments.cutoff, .point = *point}, session.bounds);
    if (report.fixes.empty() && !report.without_point.empty()) {
        complain("no fix has a yaw, so that nobody knows where the point --point is: leave --point out, or give the truth of the robot's middle");
        return bad_input;
    }
    if (report.fixes.empty() && !(report.unknown_things.in_truth && report.unknown_things.fixes > 0)) {
        complain("no fix has a true pose beside it: are both of the same session, with the same clock and the same names of robots?");
        return bad_input;
    }
    std::cout << text_of(report);
    if (!session.advice.empty()) std::cout << "stated sigmas that are too small ('roomfix calibrate site SESSION --write' sets them):\n";
    for (const SigmaAdvice& advice : session.advice) std::cout << "  " << text_of(advice) << "\n";
    if (!arguments.json.empty() && !write_file(arguments.json, json_of(report))) return failed;
    if (!arguments.report.empty()) {
        const std::string title = "Fixes of " + std::filesystem::path(arguments.fixes).filename().string() + " beside the truth";
        if (!write_file(arguments.report, html_of(report, title))) return failed;
        say("report: " + arguments.report);
    }
    if (!arguments.tum.empty() && !write_tum(arguments.tum, report, *truth)) return failed;
    return done;
}

}  // namespace

void add_evaluate(Command& program) {
    Command command =
        program.add_command("evaluate", "fixes beside the truth: errors, consistency, availability, identity switches, GOSPA, IDF1, HOTA, unknown things");
    auto arguments = std::make_shared<Arguments>();
    command.option("FIXES", arguments->fixes, "file of fixes, as 'run' and 'replay' write it").required();
    command
        .option("--truth", arguments->truth,
                "CSV with time,robot,x,y,yaw; yaw may be empty, or missing altogether; robot unknown-1, ... is a person or a thing")
        .required();
    command.option("--point", arguments->point, "X,Y,Z: the truth is about this point of the robot (m; x forward, y left, z up) and not about its middle");
    command.option("--session", arguments->session,
                   "session folder of the fixes: says how far they are from the best that its sources allow, and which stated sigmas are too small");
    command.option("--report", arguments->report, "page to write: tables, map, plots, all in one HTML file");
    command.option("--json", arguments->json, "the same figures as JSON");
    command.option("--tum", arguments->tum, "folder for the poses in TUM format, which the tool evo reads");
    command.option("--symmetry-deg", arguments->symmetry_deg, "yaws that far apart count as the same: 180 for a box whose front nobody can tell")
        .range(0.0, 360.0);
    command.option("--cutoff", arguments->cutoff, "m: a fix that is farther from a robot is not about it, in GOSPA, IDF1 and HOTA (default 1)")
        .range(0.01, 100.0);
    command.footer("Example: roomfix evaluate fixes.jsonl --truth session/truth.csv --report errors.html");
    command.on_run([=] { return evaluate(*arguments); });
}

}  // namespace roomfix
