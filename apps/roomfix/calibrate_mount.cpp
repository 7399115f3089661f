#include <fmt/format.h>

#include <cmath>
#include <memory>

#include "calibrate.hpp"
#include "commands.hpp"
#include "roomfix/pipeline/mount_session.hpp"
#include "roomfix/site/site_text.hpp"
#include "terminal.hpp"

namespace roomfix {
namespace {

struct MountArguments {
    std::string site;
    std::string camera;
    std::string frames;
    double position_sigma_mm = 5;
    WriteOptions write;
};

void print(const MountCalibration& found, const std::string& camera) {
    fmt::print("camera {}: {} pictures over {:.0f} deg of turning, residual {:.3f} px rms, the robot kept to the spot within {:.1f} mm\n", camera, found.frames,
               degrees(found.turned), found.pixel_rms, 1e3 * found.spot_sigma);
    fmt::print("  tilt {:.3f} deg +- {:.3f} deg\n", degrees(found.tilt), degrees(found.tilt_sigma));
    fmt::print("  with the mount of the site file, fixes under this ceiling are off by {:.2f} cm\n", 100 * found.offset);
    for (const std::string& what : found.not_observed) fmt::print("  not to be seen in this session: {}; the site file's value is kept\n", what);
}

int calibrate_mount_command(const MountArguments& arguments) {
    const auto known = load_camera(arguments.site, arguments.camera);
    if (!known) return give_up(known.error());
    const Site* site = &known->site;
    const SiteCamera* camera = &known->camera;
    const MountSettings settings{.position_sigma = 1e-3 * arguments.position_sigma_mm};
    const std::string frames = arguments.frames.empty() ? resolved_path(*site, camera->source) : arguments.frames;
    const auto found = calibrate_mount_from(*site, *camera, frames, settings, progress_bar("looking for landmarks"));
    if (!found) return give_up(found.error());
    print(*found, camera->id);
    Mount mount = std::get<Mount>(camera->placement);
    mount.robot_from_camera = found->robot_from_camera;
    mount.has_covariance = true;
    // How far a tilt puts fixes off, at a ceiling's height: that is what a mount is for.
    constexpr double rise = 2.5;
    const auto error = [&](const Matrix6d& covariance) { return rise * std::sqrt(covariance(3, 3) + covariance(4, 4)); };
    const Mount& before = std::get<Mount>(camera->placement);
    const Quality quality{before.has_covariance ? 1e3 * error(before.robot_from_camera.covariance) : 0, 1e3 * error(mount.robot_from_camera.covariance),
                          "mm by its tilt under a ceiling 2.5 m above"};
    return write_or_show(arguments.site, camera->id, {{"mount", mount_text(mount, camera->model)}}, quality, arguments.write);
}

}  // namespace

void add_calibrate_mount(CLI::App& calibrate, int& exit_code) {
    auto* mount =
        calibrate.add_subcommand("mount", "a camera's tilt and place on its robot, from pictures taken while the robot turns on the spot below a landmark");
    auto arguments = std::make_shared<MountArguments>();
    mount->add_option("SITE", arguments->site, "site file")->required();
    mount->add_option("--camera", arguments->camera, "camera with a 'mount'")->required();
    mount->add_option("--frames", arguments->frames, "folder or video of the turn (default: the camera's source)");
    mount->add_option("--position-sigma", arguments->position_sigma_mm, "mm: how well its place on the robot was measured")
        ->capture_default_str()
        ->check(CLI::Range(0.01, 1000.0));
    add_write_options(*mount, arguments->write);
    mount->footer("Example: roomfix simulate kim2011-spin -o /tmp/spin && roomfix calibrate mount /tmp/spin/site.yaml --camera up");
    mount->callback([=, &exit_code] { exit_code = calibrate_mount_command(*arguments); });
}

}  // namespace roomfix
