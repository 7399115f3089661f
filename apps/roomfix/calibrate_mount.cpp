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
    std::string odometry;
    bool no_odometry = false;
    double position_sigma_mm = 5;
    double heading_sigma_deg = degrees(MountSettings{}.heading_sigma);
    WriteOptions write;
};

void print(const MountCalibration& found, const std::string& camera) {
    fmt::print("camera {}: {} pictures over {:.0f} deg of turning, residual {:.3f} px rms{}\n", camera, found.frames, degrees(found.turned), found.pixel_rms,
               found.refused > 0 ? fmt::format("; {} more contradict them and were left out", found.refused) : "");
    if (found.with_wheels) {
        fmt::print("  the robot drove {:.1f} m; its wheels' scale is off by {:+.2f} %, their heading drifts by {:+.2f} deg/s\n", found.driven,
                   100 * found.wheel_scale, degrees(found.wheel_drift));
    } else {
        fmt::print("  no odometry: taken for a turn on the spot, to which the robot kept within {:.1f} mm\n", 1e3 * found.spot_sigma);
    }
    const Matrix6d& c = found.robot_from_camera.covariance;
    const Eigen::Vector3d p = found.robot_from_camera.pose.translation();
    fmt::print("  at ({:.1f}, {:.1f}, {:.1f}) +- ({:.1f}, {:.1f}, {:.1f}) mm on the robot, heading +- {:.3f} deg\n", 1e3 * p.x(), 1e3 * p.y(), 1e3 * p.z(),
               1e3 * std::sqrt(c(0, 0)), 1e3 * std::sqrt(c(1, 1)), 1e3 * std::sqrt(c(2, 2)), degrees(std::sqrt(c(5, 5))));
    fmt::print("  tilt {:.3f} deg +- {:.3f} deg\n", degrees(found.tilt), degrees(found.tilt_sigma));
    fmt::print("  with the mount of the site file, fixes under this ceiling are off by {:.2f} cm\n", 100 * found.offset);
    for (const std::string& what : found.not_observed) fmt::print("  not to be seen in this session: {}; the site file's value is kept\n", what);
}

/// The file of the wheels: the one that was given, or the robot's own.
std::string odometry_of(const MountArguments& arguments, const Site& site, const std::string& robot) {
    if (arguments.no_odometry || !arguments.odometry.empty()) return arguments.no_odometry ? "" : arguments.odometry;
    const auto index = site.robot(robot);
    if (!index || !site.robots[static_cast<std::size_t>(*index)].odometry) return "";
    const std::string& source = site.robots[static_cast<std::size_t>(*index)].odometry->source;
    return source.empty() ? "" : resolved_path(site, source);
}

int calibrate_mount_command(const MountArguments& arguments) {
    const auto known = load_camera(arguments.site, arguments.camera);
    if (!known) return give_up(known.error());
    const Site* site = &known->site;
    const SiteCamera* camera = &known->camera;
    const auto* fixed = std::get_if<Mount>(&camera->placement);
    if (fixed == nullptr) return give_up(Error{fmt::format("camera {} rides on no robot: calibrate floor is what it needs", camera->id)});
    const MountSettings settings{.position_sigma = 1e-3 * arguments.position_sigma_mm, .heading_sigma = radians(arguments.heading_sigma_deg)};
    const std::string frames = arguments.frames.empty() ? resolved_path(*site, camera->source) : arguments.frames;
    const auto found =
        calibrate_mount_from(*site, *camera, frames, odometry_of(arguments, *site, fixed->robot), settings, progress_bar("looking for landmarks"));
    if (!found) return give_up(found.error());
    print(*found, camera->id);
    Mount mount = std::get<Mount>(camera->placement);
    mount.robot_from_camera = found->robot_from_camera;
    mount.has_covariance = true;
    mount.by_intrinsics = camera->intrinsics_covariance.isZero(0) ? PoseByIntrinsics::Zero() : found->by_intrinsics;
    const Mount& before = std::get<Mount>(camera->placement);
    const Quality quality{before.has_covariance ? 1e3 * tilt_error(before.robot_from_camera.covariance) : 0,
                          1e3 * tilt_error(mount.robot_from_camera.covariance), "mm by its tilt under a ceiling 2.5 m above"};
    return write_or_show(arguments.site, camera->id, {{"mount", mount_text(mount, camera->model)}}, quality, arguments.write);
}

}  // namespace

void add_calibrate_mount(Command& calibrate) {
    Command mount = calibrate.add_command("mount", "a camera's tilt and place on its robot, from pictures of landmarks taken while it turns and drives");
    auto arguments = std::make_shared<MountArguments>();
    mount.option("SITE", arguments->site, "site file").required();
    mount.option("--camera", arguments->camera, "camera with a 'mount'").required();
    mount.option("--frames", arguments->frames, "folder or video of the drive (default: the camera's source)");
    mount.option("--position-sigma", arguments->position_sigma_mm, "mm: how well its place on the robot was measured").show_default().range(0.01, 1000.0);
    mount.option("--heading-sigma-deg", arguments->heading_sigma_deg, "how well its turn about the vertical was set").show_default().range(0.001, 180.0);
    mount.option("--odometry", arguments->odometry, "CSV of the robot's wheels (default: the robot's odometry source)");
    mount.flag("--no-odometry", arguments->no_odometry, "take the recording for a turn on the spot");
    add_write_options(mount, arguments->write);
    mount.footer("Example: roomfix simulate kim2011-drive -o /tmp/drive && roomfix calibrate mount /tmp/drive/site.yaml --camera up");
    mount.on_run([=] { return calibrate_mount_command(*arguments); });
}

}  // namespace roomfix
