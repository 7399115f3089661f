// Calibrations at full length: are their covariances true, and how good is a floor from one tile?
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include "roomfix/base/decompositions.hpp"
#include "roomfix/base/random.hpp"
#include "roomfix/calibrate/lens.hpp"
#include "roomfix/calibrate/plumb_line.hpp"
#include "roomfix/calibrate/tile_grid.hpp"
#include "roomfix/evaluate/simulated_boards.hpp"
#include "roomfix/evaluate/simulated_calibration.hpp"
#include "roomfix/evaluate/tracker_experiment.hpp"
#include "roomfix/simulate/camera_renderer.hpp"
#include "roomfix/simulate/plane_picture.hpp"
#include "roomfix/simulate/room_shots.hpp"

namespace {

using namespace roomfix;

const Chessboard board{9, 6, 0.025};
const Eigen::Vector2d board_size(8 * 0.025, 5 * 0.025);

/// How often true numbers lie inside their 95 % intervals.
struct Coverage {
    int inside = 0, all = 0;
    void add(double error, double sigma) {
        inside += std::abs(error) < 1.96 * sigma;
        ++all;
    }
    double percent() const { return 100.0 * inside / std::max(all, 1); }
};

/// Corners read from rendered pictures of a glued board.
std::vector<BoardShot> photographed_boards(const CameraModel& camera, std::uint64_t seed, Random& random) {
    std::vector<BoardShot> shots;
    PlanePictures pictures(camera, SensorModel{}, seed);
    const PrintedBoard made = glued_board(board, random);
    LumaImage picture;
    for (const Eigen::Isometry3d& pose : board_poses(camera, board_size, 15, random)) {
        photograph(pictures, pattern_of(board), shown(made, in_a_hand, random), pose, shots.size(), picture);
        shots.push_back(find_chessboard(picture, board, fmt::format("shot {}", shots.size())));
    }
    return shots;
}

CameraModel random_camera(Distortion kind, Random& random) {
    switch (kind) {
        case Distortion::plumb_bob:
            break;
        case Distortion::rational_polynomial:
            return make_camera_model(640, 480, random.uniform(380, 420), random.uniform(380, 420), 322, 238, {0.4, 0.1, 0.001, -0.0006, 0.01, 0.7, 0.2, 0.02},
                                     kind);
        case Distortion::equidistant:
            return make_camera_model(640, 480, random.uniform(270, 310), random.uniform(270, 310), 318, 243, {-0.02, 0.01, -0.004, 0.001}, kind);
    }
    return make_camera_model(640, 480, random.uniform(480, 600), random.uniform(480, 600), random.uniform(305, 335), random.uniform(225, 255),
                             {random.uniform(-0.3, 0.1), random.uniform(-0.05, 0.1), 0.001, -0.0006, 0.01});
}

enum class Boards { flat, glued, rendered };

void measure_lens(Distortion kind, Boards boards, int runs) {
    Random random(1 + static_cast<std::uint64_t>(kind));
    Coverage coverage;
    double noise = 0, nees = 0, off = 0, off_as_if_exact = 0;
    int failed = 0;
    for (int run = 0; run < runs; ++run) {
        const CameraModel camera = random_camera(kind, random);
        const std::vector<BoardShot> shots = boards == Boards::rendered ? photographed_boards(camera, random.bits(), random)
                                             : boards == Boards::glued  ? seen_boards(camera, glued_board(board, random), in_a_hand, 15, 0.05, random)
                                                                        : seen_boards(camera, PrintedBoard(board), standing_still, 15, 0.1, random);
        const auto lens = calibrate_lens(shots, 640, 480, board, {.kind = kind});
        if (!lens) {
            ++failed;
            continue;
        }
        noise += lens->sigma;
        const int count = camera.intrinsics_count();
        const Eigen::VectorXd error = (lens->model.intrinsics() - camera.intrinsics()).head(count);
        for (int i = 0; i < count; ++i) coverage.add(error[i], std::sqrt(lens->covariance(i, i)));
        nees += error.dot(lens->covariance.topLeftCorner(count, count).ldlt().solve(error)) / count;
        off += std::abs(error[0]);
        if (const auto exact = calibrate_lens(shots, 640, 480, board, {.kind = kind, .exact_board = true})) {
            off_as_if_exact += std::abs(exact->model.fx - camera.fx);
        }
    }
    static const std::map<Boards, const char*> names = {{Boards::flat, "exact boards"}, {Boards::glued, "glued boards"}, {Boards::rendered, "rendered"}};
    const int good = std::max(runs - failed, 1);
    fmt::print(
        "lens {:20} {:12} {} runs: {:.1f} % of the true numbers inside their 95 % intervals (goal 93); NEES {:.2f} per number; fx off by {:.2f} px "
        "({:.2f} with --exact-board); corner noise {:.3f} px; {} failed\n",
        name_of(kind), names.at(boards), runs, coverage.percent(), nees / good, off / good, off_as_if_exact / good, noise / good, failed);
}

struct FloorRun {
    bool doubtful = false;
    Vector6d off = Vector6d::Zero(), sigma = Vector6d::Zero();  // of the pose
    double nees = 0, error = 0, stated = 0;
};

/// One clicked tile three metres away, alone or with the joints of the whole floor; the error is that of a place six metres away.
FloorRun calibrate_floor_once(bool joints, std::uint64_t seed) {
    Random random(seed);
    const CameraModel camera = make_camera_model(640, 480, 518, 518, 320.5, 238, {-0.1, 0.02, 0.0005, -0.001, 0});
    const View truth{
        camera,
        {looking_at({random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5), random.uniform(2.2, 2.6)}, {random.uniform(3.5, 4.5), random.uniform(-0.3, 0.3), 0}),
         Matrix6d::Zero()}};
    FloorSource clicks{"clicks"};
    for (const Eigen::Vector2d& corner : {Eigen::Vector2d(3, 0), {3.3, 0}, {3.3, 0.3}, {3, 0.3}}) {
        const Eigen::Vector2d pixel = *project_map_point(truth, {corner.x(), corner.y(), 0});
        clicks.sightings.push_back(clicked_point(pixel + Eigen::Vector2d(random.normal(0.5), random.normal(0.5)), corner, 0.5));
    }
    auto found = calibrate_floor(camera, IntrinsicsMatrix::Zero(), {clicks});
    FloorRun run;
    if (joints && found) {
        LumaImage picture;
        CameraRenderer(Scene{}, truth, {}, seed).render({}, 1, 0, picture);
        UncertainPose3 start;
        const FloorSource grid = find_tile_grid_from_either(picture, camera, *found, {{3, 0, 0}, 0.3}, {clicks}, start);
        found = calibrate_floor(camera, IntrinsicsMatrix::Zero(), {clicks, grid}, start);
    }
    run.doubtful = !found || found->rival;
    if (run.doubtful) return run;
    const Vector6d off = error_between(truth.map_from_camera.pose, found->map_from_camera.pose);
    run.off = off;
    run.sigma = found->map_from_camera.covariance.diagonal().cwiseSqrt();
    run.nees = off.dot(found->map_from_camera.covariance.ldlt().solve(off));
    const View view{camera, found->map_from_camera};
    const Eigen::Vector2d place(6, 0.2), pixel = *project_map_point(truth, {place.x(), place.y(), 0});
    run.error = (pixel_to_plane(view, pixel, 0)->point - place).norm();
    run.stated = floor_sigma(view, pixel).value_or(0);
    return run;
}

void measure_floor(bool joints, int runs) {
    double nees = 0, squares = 0, stated = 0, largest = 0;
    int doubtful = 0, good = 0;
    Coverage coverage;
    for (int i = 0; i < runs; ++i) {
        const FloorRun run = calibrate_floor_once(joints, 1000 + static_cast<std::uint64_t>(i));
        if (run.doubtful) {
            ++doubtful;
            continue;
        }
        nees += run.nees;
        squares += run.error * run.error;
        stated += run.stated * run.stated;
        largest = std::max(largest, run.error);
        for (int k = 0; k < 6; ++k) coverage.add(run.off[k], run.sigma[k]);
        ++good;
    }
    const double spread = 1.96 * std::sqrt(12.0 / good);
    fmt::print(
        "floor from one tile{}: {} runs, {} say that the camera may be elsewhere; {:.1f} % of the true numbers inside their 95 % intervals (goal 93); NEES "
        "{:.2f} ({:.2f}-{:.2f}); 6 m away {:.1f} mm rms, {:.1f} at most (goal 10 with the grid), {:.1f} stated\n",
        joints ? " and the grid" : ", four clicks alone", runs, doubtful, coverage.percent(), nees / good, 6 - spread, 6 + spread,
        1e3 * std::sqrt(squares / good), 1e3 * largest, 1e3 * std::sqrt(stated / good));
}

/// A robot that turns on the spot below a landmark, or drives around it: tilt and place of its camera, and of a drive the heading, too.
void measure_mount(bool drives, int runs) {
    Random random(3);
    Coverage coverage;
    const CameraOnRobot level{kim2011_spin_scenario(1, 0).site.cameras[0].model, {looking_up(0.30), Matrix6d::Zero()}};
    const MountSettings settings{.point_sigma = 1e-6};
    double nees = 0;
    int good = 0;
    for (int run = 0; run < runs; ++run) {
        CameraOnRobot truth = level;
        Vector6d error = Vector6d::Zero();
        for (int k = 0; k < 3; ++k) error[k] = random.normal(settings.position_sigma);
        error[3] = random.normal(radians(0.5));
        error[4] = random.normal(radians(0.5));
        if (drives) error[5] = random.normal(settings.heading_sigma);
        truth.robot_from_camera.pose = perturbed(truth.robot_from_camera.pose, error);
        SeenDrive seen;
        if (drives) {
            seen = seen_drive(truth, 0.02, 100 + static_cast<std::uint64_t>(run));
        } else {
            seen.frames = seen_turn(truth, 2 * std::numbers::pi, 60, 0.02, 0.002, random);
        }
        const auto found = calibrate_mount(level, seen.frames, settings, seen.wheels);
        if (!found) continue;
        ++good;
        const Vector6d off = error_between(truth.robot_from_camera.pose, found->robot_from_camera.pose);
        const Matrix6d& c = found->robot_from_camera.covariance;
        for (int k = 0; k < (drives ? 6 : 5); ++k) coverage.add(off[k], std::sqrt(c(k, k)));
        nees += drives ? off.dot(c.ldlt().solve(off)) : off.head<5>().dot(c.topLeftCorner<5, 5>().ldlt().solve(off.head<5>()));
    }
    fmt::print("mount from a {}: {} of {} runs, {:.1f} % of the true numbers inside their 95 % intervals (goal 93); NEES {:.2f} of {}\n",
               drives ? "drive" : "turn on the spot", good, runs, coverage.percent(), nees / good, drives ? 6 : 5);
}

/// A lens from the straight edges of six furnished rooms.
void measure_lines(int runs) {
    Random random(9);
    Coverage coverage;
    double nees = 0;
    int failed = 0;
    for (int run = 0; run < runs; ++run) {
        const CameraModel truth = make_camera_model(640, 480, 420, 420, random.uniform(310, 330), random.uniform(230, 250),
                                                    {random.uniform(-0.3, -0.05), random.uniform(0.04, 0.12), random.normal(3e-4), random.normal(3e-4), 0});
        RoomRenderer renderer(truth, room_sensor(), {}, static_cast<std::uint64_t>(run));
        std::vector<LongEdge> edges;
        LumaImage picture;
        for (std::uint64_t i = 0; i < 6; ++i) {
            const RoomShot shot = cluttered_shot(random);
            renderer.render(shot.scene, shot.map_from_camera, shot.light, i, picture);
            for (LongEdge& edge : long_edges(picture, i)) edges.push_back(std::move(edge));
        }
        const auto found = straighten(std::move(edges), make_camera_model(640, 480, 420, 420, 319.5, 239.5));
        if (!found) {
            ++failed;
            continue;
        }
        const Eigen::Matrix<double, 6, 1> off = (found->model.intrinsics() - truth.intrinsics()).segment<6>(2);  // cx, cy, k1, k2, p1, p2
        const Eigen::Matrix<double, 6, 6> covariance = found->covariance.block<6, 6>(2, 2);
        for (int i = 0; i < off.size(); ++i) coverage.add(off[i], std::sqrt(covariance(i, i)));
        nees += off.dot(covariance.ldlt().solve(off)) / static_cast<double>(off.size());
    }
    fmt::print("lens from straight edges: {} runs, {:.1f} % of the true numbers inside their 95 % intervals; NEES {:.2f} per number; {} failed\n", runs,
               coverage.percent(), nees / std::max(runs - failed, 1), failed);
}

/// All cameras of a hall from drives of 30 s, by what locates the robot.
void measure_sites(int runs) {
    const auto with = [](auto... members) {
        HallSenses senses;
        ((senses.*members = true), ...);
        return senses;
    };
    const std::pair<const char*, HallSenses> all[] = {
        {"two cameras", with(&HallSenses::cameras)},
        {"two cameras, wheels", with(&HallSenses::cameras, &HallSenses::odometry)},
        {"landmarks, wheels", with(&HallSenses::ceiling, &HallSenses::odometry)},
        {"corners, wheels", with(&HallSenses::corners, &HallSenses::odometry)},
        {"all of them", with(&HallSenses::cameras, &HallSenses::ceiling, &HallSenses::corners, &HallSenses::ranges, &HallSenses::odometry)}};
    for (const auto& [name, senses] : all) {
        const SiteCalibrationResult r = measure_site_calibration(name, senses, 30, runs, 3);
        fmt::print("site, {}: {} cameras, {:.1f} % inside, NEES {:.2f} of 6, turned wrongly by {:.3f} deg before and {:.3f} after\n", name, r.cameras,
                   100 * r.coverage, r.nees, degrees(r.turn_before), degrees(r.turn_now));
    }
}

}  // namespace

/// Without arguments everything; else what is named: lens, floor, lines, mount, site, rendered.
int main(int argc, char** argv) {
    std::setvbuf(stdout, nullptr, _IOLBF, BUFSIZ);
    const std::vector<std::string> asked(argv + 1, argv + argc);
    const auto wanted = [&](const char* what) { return asked.empty() || std::find(asked.begin(), asked.end(), what) != asked.end(); };
    for (const Distortion kind : {Distortion::plumb_bob, Distortion::rational_polynomial, Distortion::equidistant}) {
        if (!wanted("lens")) break;
        measure_lens(kind, Boards::flat, 200);
        measure_lens(kind, Boards::glued, 200);
    }
    if (wanted("floor")) {
        measure_floor(false, 200);
        measure_floor(true, 200);
    }
    if (wanted("lines")) measure_lines(60);
    if (wanted("mount")) {
        measure_mount(false, 200);
        measure_mount(true, 200);
    }
    if (wanted("site")) measure_sites(40);
    for (const Distortion kind : {Distortion::plumb_bob, Distortion::equidistant}) {
        if (wanted("rendered")) measure_lens(kind, Boards::rendered, 40);
    }
    return 0;
}
