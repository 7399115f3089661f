#include "roomfix/evaluate/li2014_experiment.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "roomfix/evaluate/consistency.hpp"
#include "roomfix/evaluate/outline_bound.hpp"

namespace roomfix {
namespace {

constexpr double quarter_turn = std::numbers::pi / 2;
constexpr int background_frames = 40;
constexpr int published_background_frames = 150;  // section 4.2

/// A camera with its backgrounds learned, ready for test points.
struct SimulatedCamera {
    CameraRenderer renderer;
    OverheadObserver observer;
    std::optional<Li2014> published;
};

Result<SimulatedCamera> simulate_camera(const Scenario& scenario, std::size_t index, const Scene& scene, std::uint64_t seed, bool with_published) {
    const ScenarioCamera& camera = scenario.cameras[index];
    const auto view = fixed_view(scenario.site.cameras[index]);
    if (!view) return view.error();
    SimulatedCamera simulated{CameraRenderer(scene, camera.truth, camera.sensor, seed * 31 + index), OverheadObserver(*view, scenario.site.robots), {}};
    Random random(seed * 977 + index);
    BackgroundLearner learner;
    std::vector<LumaImage> frames;
    const int count = with_published ? published_background_frames : background_frames;
    for (int i = 0; i < count; ++i) {
        LumaImage frame;
        simulated.renderer.render({}, light_at(0.1 * i, seed + index), 1'000'000 + static_cast<std::uint64_t>(i), frame);
        if (i < background_frames) learner.add(frame);
        if (with_published) frames.push_back(std::move(frame));
    }
    simulated.observer.set_background(learner.learn());
    if (with_published) {
        const auto rectangle = li2014_rectangle(camera, 0.5, random);
        auto published = Li2014::set_up(view->model, rectangle, li2014_aisle_ahead(camera.truth));
        if (!published) return published.error();
        published->set_background(frames);
        simulated.published = std::move(*published);
    }
    return simulated;
}

/// The scenario with cameras that their user calibrated.
Result<Scenario> calibrated_scenario(std::uint64_t seed, const BoardPictures& board) {
    Scenario scenario = li2014_scenario(seed);
    if (board.shots == 0) return scenario;
    for (std::size_t i = 0; i < scenario.cameras.size(); ++i) {
        const ScenarioCamera& truth = scenario.cameras[i];
        SiteCamera& known = scenario.site.cameras[i];
        const auto lens = photographed_lens(truth.truth.model, truth.sensor, seed * 11 + i, board);
        if (!lens) return Error{fmt::format("the lens of {}: {}", truth.id, lens.error().message)};
        known.model = lens->model;
        known.intrinsics_covariance = lens->covariance;
        const auto pose = photographed_floor(truth, scenario.scene, known, li2014_tile, seed * 11 + i);
        if (!pose) return Error{fmt::format("the floor of {}: {}", truth.id, pose.error().message)};
        known.placement = *pose;
    }
    return scenario;
}

double position_sigma(const Eigen::Matrix3d& covariance) { return std::sqrt(covariance(0, 0) + covariance(1, 1)); }

/// True if no wall runs through the robot's footprint.
bool stands_free(const Site& site, const Pose2& pose) {
    const Eigen::Vector2d half = half_size(site.robots[0].shape).head<2>();
    const Eigen::Rotation2Dd robot_from_map(-pose.yaw);
    for (const Polyline& line : site.walls) {
        for (std::size_t i = 1; i < line.size(); ++i) {
            const Eigen::Vector2d a = robot_from_map * (line[i - 1] - Eigen::Vector2d(pose.x, pose.y));
            const Eigen::Vector2d d = robot_from_map * (line[i] - line[i - 1]);
            double enter = 0;
            double leave = 1;
            for (int axis = 0; axis < 2; ++axis) {
                const double u = (-half[axis] - a[axis]) / d[axis];
                const double v = (half[axis] - a[axis]) / d[axis];
                if (std::abs(d[axis]) < 1e-12 && std::abs(a[axis]) > half[axis]) leave = -1;
                if (std::abs(d[axis]) < 1e-12) continue;
                enter = std::max(enter, std::min(u, v));
                leave = std::min(leave, std::max(u, v));
            }
            if (enter <= leave) return false;
        }
    }
    return true;
}

/// On the test point, or within 0.4 m of it, with a heading at which the robot fits between the walls.
Pose2 place_robot(const Li2014Options& options, const Site& site, const Li2014TestPoint& point, Random& random) {
    const double reach = options.scatter ? 0.4 : 0.0;
    for (int i = 0; i < 1000; ++i) {
        const Pose2 pose{point.actual.x() + random.uniform(-reach, reach), point.actual.y() + random.uniform(-reach, reach),
                         random.uniform(-std::numbers::pi, std::numbers::pi)};
        if (stands_free(site, pose)) return pose;
    }
    return {point.actual.x(), point.actual.y(), 0};
}

/// Part of the robot's pixels that are still seen with `occluder` in the scene.
double seen_part(const Scene& scene, const View& view, const std::vector<Solid>& robot, const Solid& occluder) {
    Scene scene_with = scene;
    scene_with.furniture.push_back(occluder);
    const RayTracer without(scene), with(scene_with);
    const MovingSolids moving = without.with(robot);
    const Eigen::Vector3f origin = view.position().cast<float>();
    int before = 0;
    int after = 0;
    const Eigen::Vector2d centre = project_map_point(view, robot[0].centre.cast<double>()).value_or(Eigen::Vector2d::Zero());
    for (double v = centre.y() - 90; v < centre.y() + 90; v += 3) {
        for (double u = centre.x() - 90; u < centre.x() + 90; u += 3) {
            const auto ray = unproject(view.model, {u, v});
            if (!ray) continue;
            const Eigen::Vector3f direction = (view.map_from_camera.pose.linear() * ray->homogeneous()).cast<float>().normalized();
            const auto hits_robot = [&](const RayTracer& tracer) { return tracer.look(moving, origin, direction).solid >= 0; };
            if (!hits_robot(without)) continue;
            ++before;
            after += hits_robot(with);
        }
    }
    return before > 0 ? static_cast<double>(after) / before : 1;
}

}  // namespace

Solid occluder_for(const Scene& scene, const View& view, const std::vector<Solid>& robot, const Pose2& place, double part, int side) {
    const Eigen::Vector2d camera = view.position().head<2>();
    const Eigen::Vector2d towards = (camera - Eigen::Vector2d(place.x, place.y)).normalized();
    const Eigen::Vector2d across(-towards.y(), towards.x());
    const auto solid_at = [&](double amount) {
        Solid s;
        s.axis = towards.cast<float>();
        s.side = {0.5f, 0.05f, 0.03f};
        s.top = s.side;
        const double height = side == 2 ? amount : 1.2;
        const double shift = side == 2 ? 0 : (side == 0 ? 1 : -1) * (1.1 - amount);
        const Eigen::Vector2d middle = Eigen::Vector2d(place.x, place.y) + 0.55 * towards + shift * across;
        s.half = {0.03f, side == 2 ? 0.8f : 0.5f, static_cast<float>(height / 2)};
        s.centre = {static_cast<float>(middle.x()), static_cast<float>(middle.y()), static_cast<float>(height / 2)};
        return s;
    };
    double least = 0.01;
    double most = 1.1;
    for (int i = 0; i < 12; ++i) {
        const double amount = 0.5 * (least + most);
        (1 - seen_part(scene, view, robot, solid_at(amount)) < part ? least : most) = amount;
    }
    return solid_at(0.5 * (least + most));
}

Result<Li2014Report> run_li2014(const Li2014Options& options, const std::function<void(double)>& progress) {
    Li2014Report report;
    const auto& points = li2014_test_points();
    const double total = static_cast<double>(points.size()) * options.seeds * options.fixes_per_point;
    for (int s = 0; s < options.seeds; ++s) {
        const std::uint64_t seed = options.seed + static_cast<std::uint64_t>(s);
        const auto calibrated = calibrated_scenario(seed, options.board);
        if (!calibrated) return calibrated.error();
        const Scenario& scenario = *calibrated;
        Random random(seed * 7919 + 5);
        const ShapePoints shape = shape_points(scenario.robots[0].robot.shape, scenario.robots[0].robot.size_sigma);
        std::optional<SimulatedCamera> simulated;
        int station_camera = -1;
        OverheadResult seen;
        LumaImage frame;
        for (std::size_t p = 0; p < points.size(); ++p) {
            const auto index = static_cast<std::size_t>(points[p].camera);
            const ScenarioCamera& camera = scenario.cameras[index];
            for (int f = 0; f < options.fixes_per_point; ++f) {
                Li2014Trial trial{static_cast<int>(p), seed, place_robot(options, scenario.site, points[p], random)};
                const auto solids = robot_solids(scenario.robots[0].robot.shape, scenario.robots[0].look, trial.truth);
                if (options.hidden > 0 || points[p].camera != station_camera) {
                    Scene scene = scenario.scene;
                    if (options.hidden > 0) {
                        scene.furniture.push_back(occluder_for(scene, camera.truth, solids, trial.truth, options.hidden, random.index(3)));
                    }
                    auto made = simulate_camera(scenario, index, scene, seed, options.published && options.hidden == 0);
                    if (!made) return made.error();
                    simulated = std::move(*made);
                    station_camera = points[p].camera;
                }
                const double light = options.light * light_at(30 + 3.0 * static_cast<double>(report.trials.size()), seed);
                simulated->renderer.render(solids, light, report.trials.size(), frame);
                simulated->observer.observe(frame, seen);
                if (!seen.observations.empty()) {
                    trial.ours = seen.observations[0].pose;
                    trial.covariance = seen.observations[0].covariance;
                    trial.error = pose_error(*trial.ours, trial.truth, quarter_turn);
                } else {
                    trial.reason = seen.reason;
                }
                if (simulated->published) trial.published = simulated->published->locate(frame);
                View true_view = camera.truth;
                true_view.calibration = simulated->observer.view().calibration;
                true_view.intrinsics_uncertain = simulated->observer.view().intrinsics_uncertain;
                const auto bound = outline_bound(frame, simulated->observer.background().mean(), true_view, shape, trial.truth, camera.sensor);
                trial.bound = position_sigma(bound.with_calibration);
                trial.bound_pixels = position_sigma(bound.pixels);
                report.trials.push_back(trial);
                if (progress) progress(static_cast<double>(report.trials.size()) / total);
            }
        }
    }
    return report;
}

int Li2014Report::lost() const { return count_lost(trials); }

std::vector<double> Li2014Report::position_errors() const {
    std::vector<double> errors;
    for (const auto& t : trials) {
        if (t.ours) errors.push_back(position_error(t));
    }
    return errors;
}

std::vector<double> Li2014Report::yaw_errors() const {
    std::vector<double> errors;
    for (const auto& t : trials) {
        if (t.ours) errors.push_back(std::abs(t.error.z()));
    }
    return errors;
}

std::vector<double> Li2014Report::published_errors() const {
    std::vector<double> errors;
    for (const auto& t : trials) {
        if (t.published) errors.push_back((*t.published - Eigen::Vector2d(t.truth.x, t.truth.y)).norm());
    }
    return errors;
}

double Li2014Report::mean_nees() const { return mean_nees_of(trials); }

std::string li2014_table(const Li2014Report& report) {
    const auto& points = li2014_test_points();
    std::string text =
        "Li et al. 2014, Table 1. Errors in cm; simulated columns are means over the runs.\n"
        "  actual (cm)    webcam   printed  recomputed | as published   roomfix    bound (pixels only)\n";
    std::vector<double> printed;
    std::vector<double> recomputed;
    for (std::size_t p = 0; p < points.size(); ++p) {
        double ours = 0, published = 0, bound = 0, bound_pixels = 0;
        int ours_count = 0, published_count = 0, count = 0;
        for (const auto& t : report.trials) {
            if (t.point != static_cast<int>(p)) continue;
            ++count;
            bound += t.bound;
            bound_pixels += t.bound_pixels;
            if (t.ours) ours += report.position_error(t), ++ours_count;
            if (t.published) published += (*t.published - Eigen::Vector2d(t.truth.x, t.truth.y)).norm(), ++published_count;
        }
        const double again = (points[p].measured - points[p].actual).norm();
        printed.push_back(points[p].printed_error);
        recomputed.push_back(again);
        const auto centimetres = [](double sum, int n) { return n > 0 ? fmt::format("{:.2f}", 100 * sum / n) : std::string("-"); };
        text +=
            fmt::format("  ({:6.1f},{:6.1f})    {:3}   {:7.2f}  {:9.2f}  | {:>12} {:>9} {:>8} ({})\n", 100 * points[p].actual.x(), 100 * points[p].actual.y(),
                        points[p].camera + 1, 100 * points[p].printed_error, 100 * again, centimetres(published, published_count),
                        centimetres(ours, ours_count), centimetres(bound, count), centimetres(bound_pixels, count));
    }
    const Summary ours = summarise(report.position_errors());
    const Summary published = summarise(report.published_errors());
    const Summary yaw = summarise(report.yaw_errors());
    const auto row = [](const char* name, double a, double b, const Summary& c, const Summary& d, double Summary::*field) {
        const auto value = [&](const Summary& s) { return s.count ? fmt::format("{:.2f}", 100 * (s.*field)) : std::string("-"); };
        return fmt::format("  {:<15}         {:7.2f}  {:9.2f}  | {:>12} {:>9}\n", name, 100 * a, 100 * b, value(c), value(d));
    };
    text += row("mean", summarise(printed).mean, summarise(recomputed).mean, published, ours, &Summary::mean);
    text += row("max", summarise(printed).max, summarise(recomputed).max, published, ours, &Summary::max);
    text += fmt::format("  {} fixes, {} lost; yaw error (modulo 90 deg): rms {:.2f} deg, max {:.2f} deg; mean NEES {:.2f} (3 unknowns)\n", ours.count,
                        report.lost(), degrees(yaw.rms), degrees(yaw.max), report.mean_nees());
    return text;
}

}  // namespace roomfix
