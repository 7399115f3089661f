#include "roomfix/evaluate/kim2011_experiment.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "roomfix/base/decompositions.hpp"
#include "roomfix/calibrate/mount.hpp"
#include "roomfix/ceiling/ceiling_observer.hpp"
#include "roomfix/ceiling/kim2011.hpp"
#include "roomfix/ceiling/robot_locator.hpp"
#include "roomfix/evaluate/consistency.hpp"
#include "roomfix/evaluate/landmark_bound.hpp"
#include "roomfix/ranging/range_reader.hpp"
#include "roomfix/ranging/trilateration.hpp"
#include "roomfix/simulate/scenario.hpp"

namespace roomfix {
namespace {

constexpr int bounds_per_position = 15;  // it changes little from sample to sample and costs more than a fix

/// One look from a place: the picture, and what the listener heard.
struct Sample {
    LumaImage frame;
    RangeBatch heard;
    std::optional<double> rounded_distance;  // m, to the landmark's node, as the listener prints it
};

class Rig {
public:
    Rig(const Scenario& scenario, std::uint64_t seed)
        : scenario_(scenario),
          camera_(scenario.up_cameras[0]),
          renderer_(camera_.truth.model, camera_.sensor, camera_.glare, seed),
          random_(seed * 7919 + 11) {}

    Sample take(const Pose2& truth) {
        Sample sample;
        const double light = light_at(0.2 * static_cast<double>(taken_), 3);
        renderer_.render(scenario_.ceiling, map_from_robot(truth) * camera_.truth.robot_from_camera.pose, light, taken_++, sample.frame);
        RangeReader reader(scenario_.site, 0);
        const Eigen::Vector3d receiver = map_from_robot(truth) * scenario_.site.robots[0].receiver()->position;
        for (const SiteBeacon& beacon : scenario_.site.beacons) {
            const auto message = hear(scenario_.ranges, (beacon.position - receiver).norm(), random_);
            if (!message) continue;
            if (beacon.id == scenario_.site.landmarks[0].beacon) sample.rounded_distance = message->distance;
            reader.feed(cricket_line(beacon.id, *message, static_cast<long>(taken_)) + "\r\n", static_cast<Nanoseconds>(taken_) * 200'000'000, sample.heard);
        }
        return sample;
    }
    Random& random() { return random_; }

private:
    const Scenario& scenario_;
    const ScenarioUpCamera& camera_;
    CeilingRenderer renderer_;
    Random random_;
    std::uint64_t taken_ = 0;
};

double rms_over(const std::vector<Kim2011Trial>& trials, int position, const std::function<std::optional<double>(const Kim2011Trial&)>& squared) {
    double sum = 0;
    int count = 0;
    for (const Kim2011Trial& t : trials) {
        if (position >= 0 && t.position != position) continue;
        if (const auto value = squared(t)) {
            sum += *value;
            ++count;
        }
    }
    return count > 0 ? std::sqrt(sum / count) : 0;
}

std::vector<BeaconRange> beacon_ranges(const Site& site, const RangeBatch& heard) {
    std::vector<BeaconRange> ranges;
    for (const RangeObservation& r : heard.ranges) ranges.push_back({site.beacons[static_cast<std::size_t>(r.beacon)].position, r.range, r.sigma});
    return ranges;
}

/// What the camera's own uncertainty adds to any fix from this landmark at `truth`.
Eigen::Matrix3d camera_part(const CameraOnRobot& camera, const SiteLandmark& landmark, const Pose2& truth) {
    Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
    Eigen::Matrix<double, 3, camera_errors> by_camera = Eigen::Matrix<double, 3, camera_errors>::Zero();
    for (const Eigen::Vector3d& point : map_points(landmark)) {
        SeenPointJacobian j;
        if (!predict_point(camera, truth, point, &j)) continue;
        information += j.by_pose.transpose() * j.by_pose;
        by_camera.leftCols<6>() += j.by_pose.transpose() * j.by_mount;
        by_camera.rightCols<most_intrinsics>() += j.by_pose.transpose() * j.by_intrinsics;
    }
    const Eigen::Matrix<double, 3, camera_errors> moved = information.inverse() * by_camera;
    return moved * joint_covariance(camera.robot_from_camera.covariance, camera.intrinsics) * moved.transpose();
}

/// Puts into the site what its user knows of the camera: lens and mount, from rendered pictures.
Result<void> calibrate(const Kim2011Options& options, std::uint64_t seed, SiteCamera& camera, Kim2011Report& report) {
    const Scenario spin = kim2011_spin_scenario(seed, options.tilt);
    const ScenarioUpCamera& truth = spin.up_cameras[0];
    if (options.board.shots > 0) {
        const auto lens = photographed_lens(truth.truth.model, truth.sensor, seed, options.board);
        if (!lens) return lens.error();
        camera.model = lens->model;
        camera.intrinsics_covariance = lens->covariance;
    } else if (options.tilt == 0) {
        return {};
    }
    // The simulated LEDs sit exactly where the site says: what is left is what their centroids are always off by. And the robot's heading
    // is by definition the camera's.
    const MountSettings settings{.heading_sigma = 1e-4, .point_sigma = 1e-5};
    const auto found = photographed_mount(spin, camera.model, {camera.intrinsics_covariance}, settings, seed + 500);
    if (!found) return found.error();
    auto& mount = std::get<Mount>(camera.placement);
    mount.robot_from_camera = found->robot_from_camera;
    mount.by_intrinsics = found->by_intrinsics;
    report.tilt_sigma = found->tilt_sigma;
    return {};
}

double squared_distance(const Kim2011Trial& t, double x, double y) { return (x - t.truth.x) * (x - t.truth.x) + (y - t.truth.y) * (y - t.truth.y); }

}  // namespace

Result<Kim2011Report> run_kim2011(const Kim2011Options& options, const std::function<void(double)>& progress) {
    Kim2011Report report;
    report.options = options;
    const auto& positions = kim2011_positions();
    const double total = static_cast<double>(positions.size()) * options.seeds * options.samples;
    for (int s = 0; s < options.seeds; ++s) {
        const std::uint64_t seed = options.seed + static_cast<std::uint64_t>(s);
        Scenario scenario = kim2011_scenario(seed, options.tilt);
        scenario.ranges.late_share = options.late;
        if (!options.lamp) scenario.ceiling.patches.erase(scenario.ceiling.patches.begin());
        auto& mount = std::get<Mount>(scenario.site.cameras[0].placement);
        mount.has_covariance = true;  // a level mount is one that is known to be level
        if (auto calibrated = calibrate(options, seed, scenario.site.cameras[0], report); !calibrated) return calibrated.error();
        const CameraOnRobot camera = camera_on_robot(scenario.site.cameras[0], mount);
        Rig rig(scenario, seed);
        CeilingObserver observer(camera, true, scenario.site.landmarks);
        RobotLocator locator(scenario.site, 0, camera);
        Kim2011 published(scenario.site.landmarks[0], mount);
        const ScenarioUpCamera& truth_camera = scenario.up_cameras[0];
        const double rise = scenario.site.beacons[0].position.z() - scenario.site.robots[0].receiver()->position.z();
        CeilingResult seen;
        LocatedRobot located;
        for (std::size_t p = 0; p < positions.size(); ++p) {
            for (int i = 0; i < options.samples; ++i) {
                Kim2011Trial trial;
                trial.position = static_cast<int>(p);
                trial.seed = seed;
                trial.truth = {positions[p].place.x(), positions[p].place.y(), rig.random().uniform(-std::numbers::pi, std::numbers::pi)};
                const Sample sample = rig.take(trial.truth);
                observer.observe(sample.frame, seen);
                locator.locate(seen.landmarks, sample.heard.ranges, {}, located);
                if (located.places.empty()) {
                    trial.reason = seen.reason.empty() ? located.reason : seen.reason;
                } else {
                    trial.ours = located.places[0].pose;
                    trial.covariance = located.places[0].covariance;
                    trial.error = pose_error(*trial.ours, trial.truth, 2 * std::numbers::pi);
                }
                const auto ranges = beacon_ranges(scenario.site, sample.heard);
                if (i < bounds_per_position) {
                    Eigen::Matrix3d information =
                        landmark_information(scenario.ceiling, truth_camera.truth, truth_camera.sensor, truth_camera.glare, trial.truth);
                    for (const BeaconRange& r : ranges) {
                        information += range_information(r.beacon, scenario.site.robots[0].receiver()->position, r.sigma, trial.truth);
                    }
                    trial.bound = information.inverse();
                    *trial.bound += camera_part(camera, scenario.site.landmarks[0], trial.truth);
                }
                if (options.baselines) {
                    if (const auto fix = published.locate(sample.frame, sample.rounded_distance, rise)) trial.published = fix->pose;
                    const auto place = trilaterate(ranges, {}, scenario.site.robots[0].receiver()->position.z());
                    if (place && ranges.size() >= 3) trial.trilateration = place->places[0].position;
                }
                report.trials.push_back(trial);
                if (progress) progress(static_cast<double>(report.trials.size()) / total);
            }
        }
    }
    return report;
}

int Kim2011Report::lost() const { return count_lost(trials); }

double Kim2011Report::ours_rmse(int position) const {
    return rms_over(trials, position, [](const Kim2011Trial& t) { return t.ours ? std::optional(squared_distance(t, t.ours->x, t.ours->y)) : std::nullopt; });
}

double Kim2011Report::published_rmse(int position) const {
    return rms_over(trials, position,
                    [](const Kim2011Trial& t) { return t.published ? std::optional(squared_distance(t, t.published->x, t.published->y)) : std::nullopt; });
}

double Kim2011Report::trilateration_rmse(int position) const {
    return rms_over(trials, position, [](const Kim2011Trial& t) {
        return t.trilateration ? std::optional(squared_distance(t, t.trilateration->x(), t.trilateration->y())) : std::nullopt;
    });
}

double Kim2011Report::bound_rmse(int position) const {
    return rms_over(trials, position, [](const Kim2011Trial& t) { return t.bound ? std::optional((*t.bound)(0, 0) + (*t.bound)(1, 1)) : std::nullopt; });
}

double Kim2011Report::yaw_rms() const {
    return rms_over(trials, -1, [](const Kim2011Trial& t) { return t.ours ? std::optional(t.error.z() * t.error.z()) : std::nullopt; });
}

double Kim2011Report::mean_nees() const { return mean_nees_of(trials); }

std::string kim2011_table(const Kim2011Report& report) {
    const auto& positions = kim2011_positions();
    const Kim2011Options& o = report.options;
    std::string text = fmt::format(
        "Kim et al. 2011, Table 1. RMSE in cm; simulated columns over {} samples per position{}{}.\n"
        "                    printed                 | simulated\n"
        "  position (cm)   trilateration  proposed   | trilateration  as published   roomfix    bound\n",
        o.seeds * o.samples, o.tilt > 0 ? fmt::format(", mount tilted by {:.2f} deg", degrees(o.tilt)) : "",
        o.late > 0 ? fmt::format(", {:.0f} % of the ranges late", 100 * o.late) : "");
    double trilateration = 0;
    double proposed = 0;
    double proposed_squares = 0;
    for (std::size_t p = 0; p < positions.size(); ++p) {
        const int i = static_cast<int>(p);
        const double count = static_cast<double>(positions.size());
        trilateration += positions[p].trilateration / count;
        proposed += positions[p].proposed / count;
        proposed_squares += positions[p].proposed * positions[p].proposed / count;
        text += fmt::format("  ({:5.1f},{:5.1f})     {:10.3f}  {:10.3f}   | {:13.3f}  {:12.3f} {:9.3f} {:8.3f}\n", 100 * positions[p].place.x(),
                            100 * positions[p].place.y(), 100 * positions[p].trilateration, 100 * positions[p].proposed, 100 * report.trilateration_rmse(i),
                            100 * report.published_rmse(i), 100 * report.ours_rmse(i), 100 * report.bound_rmse(i));
    }
    text += fmt::format("  overall                                   | {:13.3f}  {:12.3f} {:9.3f} {:8.3f}\n", 100 * report.trilateration_rmse(),
                        100 * report.published_rmse(), 100 * report.ours_rmse(), 100 * report.bound_rmse());
    text +=
        fmt::format("  printed columns recomputed: trilateration mean {:.3f} (printed 5.972), proposed mean {:.3f}, root mean square {:.3f} (printed 2.366)\n",
                    100 * trilateration, 100 * proposed, 100 * std::sqrt(proposed_squares));
    text += fmt::format("  roomfix: {} fixes, {} lost, RMSE / bound {:.2f}, yaw rms {:.3f} deg, mean NEES {:.2f} (3 unknowns)",
                        report.trials.size() - static_cast<std::size_t>(report.lost()), report.lost(), report.ours_rmse() / report.bound_rmse(),
                        degrees(report.yaw_rms()), report.mean_nees());
    if (o.tilt > 0) text += fmt::format("; tilt calibrated to {:.3f} deg", degrees(report.tilt_sigma));
    text += "\n";
    for (const auto& t : report.trials) {
        if (t.ours) continue;
        text += fmt::format("  first lost: seed {}, position {}, yaw {:.1f} deg: {}\n", t.seed, t.position + 1, degrees(t.truth.yaw), t.reason);
        break;
    }
    return text;
}

}  // namespace roomfix
