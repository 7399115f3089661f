#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>

#include "calibrate.hpp"
#include "commands.hpp"
#include "roomfix/pipeline/replay.hpp"
#include "roomfix/pipeline/sigma_advice.hpp"
#include "roomfix/pipeline/site_calibration.hpp"
#include "roomfix/site/load_site.hpp"
#include "roomfix/site/site_text.hpp"
#include "run_site.hpp"
#include "terminal.hpp"

namespace roomfix {
namespace {

struct SiteArguments {
    std::string session;
    std::vector<std::string> cameras;
    std::vector<std::string> background;
    int threads = 1;
    WriteOptions write;
};

constexpr double surprising = 4;        // standard deviations
constexpr double contradicting = 0.33;  // part of a camera's sightings

bool is_wanted(const SiteArguments& arguments, const std::string& camera) {
    return arguments.cameras.empty() || std::find(arguments.cameras.begin(), arguments.cameras.end(), camera) != arguments.cameras.end();
}

bool rides(const SiteCamera& camera) { return std::holds_alternative<Mount>(camera.placement); }

/// Why a camera of the site has no result; empty where there is nothing to say.
std::string why_not(const SiteCamera& camera) {
    if (std::holds_alternative<KnownHeight>(camera.placement)) return "only its height is known: it may stand anywhere";
    const auto* pose = std::get_if<KnownPose>(&camera.placement);
    const auto* mount = std::get_if<Mount>(&camera.placement);
    const bool exact = (pose && !pose->has_covariance) || (mount && !mount->has_covariance);
    if (exact && camera.intrinsics_covariance.isZero(0)) {
        return fmt::format("the site file states no covariance, so it counts as exact: calibrate {} gives it one", rides(camera) ? "mount" : "floor");
    }
    return "it saw no robot, or nothing that this robot's way could explain: nothing is learned about it";
}

void print(const SiteCalibration& c) {
    const Vector6d sigma = c.covariance.diagonal().cwiseSqrt();
    const Eigen::Vector3d place = 1e3 * c.moved.head<3>(), place_sigma = 1e3 * sigma.head<3>();
    fmt::print("camera {}: {} sightings{}\n", c.camera.id, c.sightings.all,
               c.sightings.doubted > 0 ? fmt::format("; {} of them contradict all else and were left out", c.sightings.doubted) : "");
    fmt::print("  moved by ({:+.1f}, {:+.1f}, {:+.1f}) +- ({:.1f}, {:.1f}, {:.1f}) mm {}\n", place.x(), place.y(), place.z(), place_sigma.x(), place_sigma.y(),
               place_sigma.z(), rides(c.camera) ? "on its robot" : "in the map");
    fmt::print("  turned by ({:+.3f}, {:+.3f}, {:+.3f}) +- ({:.3f}, {:.3f}, {:.3f}) deg about x, y, z\n", degrees(c.moved[3]), degrees(c.moved[4]),
               degrees(c.moved[5]), degrees(sigma[3]), degrees(sigma[4]), degrees(sigma[5]));
    fmt::print("  expected error {}: {:.1f} mm before, {:.1f} mm now\n", rides(c.camera) ? "by its tilt under a ceiling 2.5 m above" : "on the floor",
               1e3 * c.error_before, 1e3 * c.error_now);
    if (c.sightings.doubted > contradicting * c.sightings.all) {
        fmt::print("  so many contradictions: was this camera, or one that sees the same places, moved since it was calibrated?\n");
    }
    if (c.surprise > surprising) {
        fmt::print("  that is {:.1f} standard deviations of what the site file states: was the camera bumped, or is the stated covariance too small?\n",
                   c.surprise);
    }
}

/// Sigmas of robots' own senses that the recording shows to be too small, as values of the file.
std::vector<SiteResult> sense_results(const std::filesystem::path& file, const std::vector<SigmaAdvice>& advice) {
    std::vector<SiteResult> results;
    const auto plain = load_site(file);  // without what a session's folder adds
    if (!plain) return results;
    for (const SiteRobot& robot : plain->robots) {
        const auto about_it = [&](const SigmaAdvice& a) { return a.robot == robot.id; };
        if (std::none_of(advice.begin(), advice.end(), about_it)) continue;
        SiteResult result{{robot.id, {}, "robots"}, {}};
        for (const auto& [key, value] : senses_text(advised(robot, advice))) result.edit.values.push_back({key, value});
        results.push_back(result);
    }
    return results;
}

SiteResult result_of(const SiteCalibration& c) {
    SiteResult result{{c.camera.id, {}}, {1e3 * c.error_before, 1e3 * c.error_now, "mm expected error"}};
    std::vector<SiteValue>& values = result.edit.values;
    if (const auto* mount = std::get_if<Mount>(&c.camera.placement)) {
        values.push_back({"mount", mount_text(*mount, c.camera.model)});
    } else {
        values.push_back({"pose", pose_text(std::get<KnownPose>(c.camera.placement), c.camera.model)});
        for (const char* old : {"floor_points", "floor_points_sigma"}) values.push_back({old, ""});
    }
    if (c.camera.intrinsics_covariance.isZero(0)) return result;
    values.push_back({"intrinsics", intrinsics_text(c.camera.model, c.camera.intrinsics_covariance)});
    if (c.camera.lens_grid.empty()) values.push_back({"distortion", distortion_text(c.camera.model)});
    return result;
}

int calibrate_site_command(const SiteArguments& arguments) {
    const std::filesystem::path file = site_file_of(arguments.session);
    const auto site = load_session(arguments.session);
    if (!site) return give_up(Error{"the session's site file cannot be used:\n" + site.error().message});
    for (const std::string& camera : arguments.cameras) {
        if (site->camera(camera) == nullptr) return give_up(Error{fmt::format("there is no camera '{}' in {}", camera, file.string())});
    }
    if (std::all_of(site->robots.begin(), site->robots.end(), [](const SiteRobot& r) { return r.many; })) {
        return give_up(
            Error{"all robots of this site are one of many ('count: many'): a robot that is the only one of its name is needed, to know its whole way"});
    }
    ReplaySettings settings;
    settings.threads = arguments.threads;
    settings.background = arguments.background;
    settings.keep_history = true;
    settings.stop = &stop_requested();
    settings.progress = progress_bar("running");
    settings.listener = background_on_terminal();
    const auto replayed = replay(*site, settings);
    if (!replayed) return give_up(replayed.error());
    const SiteTracker& tracker = *replayed->tracker;
    std::vector<SiteCalibration> calibrations;
    if (tracker.cameras() > 0) {
        calibrations = calibrated_cameras(tracker.tracker().models(), camera_errors_of(tracker.tracker(), replayed->fixes, progress_bar("calibrating")));
    }
    std::vector<SiteResult> results;
    for (const SiteCamera& camera : site->cameras) {
        if (!is_wanted(arguments, camera.id)) continue;
        const auto found = std::find_if(calibrations.begin(), calibrations.end(), [&](const SiteCalibration& c) { return c.camera.id == camera.id; });
        if (found == calibrations.end()) {
            fmt::print("camera {}: {}\n", camera.id, why_not(camera));
            continue;
        }
        print(*found);
        results.push_back(result_of(*found));
    }
    const auto advice = sigma_advice(tracker.tracker());
    for (const SigmaAdvice& one : advice) fmt::print("{}\n", text_of(one));
    if (arguments.cameras.empty()) {
        for (const SiteResult& result : sense_results(file, advice)) results.push_back(result);
    }
    if (results.empty()) {
        complain("nothing was learned about any camera or sense: record a session in which a robot drives through what they see");
        return failed;
    }
    return write_or_show(file.string(), results, arguments.write);
}

}  // namespace

void add_calibrate_site(Command& calibrate) {
    Command site = calibrate.add_command(
        "site", "all cameras at once, and the sigmas of robots' own senses, from a recorded session in which robots drive through what they see");
    auto arguments = std::make_shared<SiteArguments>();
    site.option("SESSION", arguments->session, "session folder, or a site file whose sources are recordings").required();
    site.repeatable("--camera", arguments->cameras, "only this one is printed and written (default: all)");
    add_recording_options(site, arguments->background, arguments->threads);
    add_write_options(site, arguments->write);
    site.footer(
        "The site file's covariances count as what was known before: calibrate floor, mount and lens first, and use each session only once.\n"
        "Example: roomfix simulate li2014 -o /tmp/li2014 --duration 76 && roomfix calibrate site /tmp/li2014 --write");
    site.on_run([=] { return calibrate_site_command(*arguments); });
}

}  // namespace roomfix
