// Two robots of the same look cross in front of a rendered camera: from pixels to names.
#include <algorithm>
#include <atomic>
#include <cmath>

#include "roomfix/base/random_vector.hpp"
#include "roomfix/base/worker_pool.hpp"
#include "roomfix/evaluate/crossing.hpp"
#include "roomfix/geometry/convex_hull.hpp"
#include "roomfix/overhead/overhead_observer.hpp"
#include "roomfix/simulate/camera_renderer.hpp"
#include "roomfix/simulate/scenario.hpp"

namespace roomfix {
namespace {

constexpr double half_gap = 0.36;  // m, of the lanes from the middle: the robots pass 18 cm apart
constexpr double frame_seconds = 0.1;
constexpr double end = 8;

/// An empty hall, seen from the middle of one side.
struct Hall {
    Scene scene;
    View view;

    explicit Hall(std::uint64_t seed) {
        scene.seed = seed;
        scene.walls = panels_along({{{-4, -4}, {4, -4}, {4, 3}, {-4, 3}, {-4, -4}}}, 2.8f);
        for (const float x : {-2.5f, 0.0f, 2.5f}) scene.lamps.push_back({{x, 0.3f, 2.75f}, 2.2f, 0.06f});
        view.model = make_camera_model(640, 480, 430, 430, 319, 241, {-0.05, 0.01, 0, 0, 0});
        view.map_from_camera.pose = looking_at({0, -3.8, 2.4}, {0, 0.2, 0});
        view.map_from_camera.covariance = 1e-6 * Matrix6d::Identity();
    }
};

std::vector<Eigen::Vector2d> outline(const View& view, const Pose2& pose) {
    std::vector<Eigen::Vector2d> points;
    for (int i = 0; i < 8; ++i) {
        const Eigen::Vector3d own((i & 1 ? 0.5 : -0.5) * crossing_body.length, (i & 2 ? 0.5 : -0.5) * crossing_body.width, i & 4 ? crossing_body.height : 0);
        if (const auto pixel = project_map_point(view, map_from_robot(pose) * own)) points.push_back(*pixel);
    }
    return hull_of(points);
}

bool inside(const std::vector<Eigen::Vector2d>& hull, const Eigen::Vector2d& p) {
    bool left = true, right = true;
    for (std::size_t i = 0; i < hull.size(); ++i) {
        const Eigen::Vector2d side = hull[(i + 1) % hull.size()] - hull[i];
        const Eigen::Vector2d to = p - hull[i];
        const double cross = side.x() * to.y() - side.y() * to.x();
        left = left && cross >= 0;
        right = right && cross <= 0;
    }
    return left || right;
}

/// Part of the farther robot's outline that the nearer one covers.
double hidden_part(const View& view, const Pose2& nearer, const Pose2& farther) {
    const auto front = outline(view, nearer), back = outline(view, farther);
    int all = 0, covered = 0;
    for (int y = 0; y < view.model.height; y += 4) {
        for (int x = 0; x < view.model.width; x += 4) {
            if (!inside(back, {x, y})) continue;
            ++all;
            covered += inside(front, {x, y});
        }
    }
    return all == 0 ? 0 : static_cast<double>(covered) / all;
}

struct OneCrossing {
    CrossingResult result;
    double hidden = 0;  // of the farther robot's outline, at most
};

OneCrossing cross(bool odometry, std::uint64_t seed) {
    OneCrossing one;
    Random random(seed);
    const Hall hall(random.bits());
    Site site;
    site.robots = like_robots(odometry);
    SiteCamera camera;
    camera.id = "side";
    camera.model = hall.view.model;
    camera.placement.emplace<KnownPose>(KnownPose{hall.view.map_from_camera, true});
    site.cameras.push_back(camera);
    Tracker tracker(site);
    const std::array<Passage, 2> ways = random_passages(half_gap, random);
    auto wheels = wheels_of(ways, random);

    // The camera stands a little off from where its calibration says.
    View truth = hall.view;
    truth.map_from_camera.pose.translation() += 1e-3 * normal3(random);
    const CameraRenderer renderer(hall.scene, truth, {}, random.bits());
    OverheadObserver observer(hall.view, site.robots);
    LumaImage frame;
    BackgroundLearner learner;
    const std::uint64_t light = random.bits();
    for (int i = 0; i < 12; ++i) {
        renderer.render({}, light_at(-0.1 * i, light), 1'000'000 + static_cast<std::uint64_t>(i), frame);
        learner.add(frame);
    }
    observer.set_background(learner.learn());
    // Their names are told once, as a tag or a person would.
    for (int r = 0; r < 2; ++r) {
        PoseObservation first;
        first.robot = r;
        first.pose = ways[static_cast<std::size_t>(r)].at(0);
        first.covariance = Eigen::Vector3d(1e-4, 1e-4, 4e-4).asDiagonal();
        first.identified = true;
        tracker.observe(from_seconds(0.0), r == 0 ? "door 1" : "door 2", {&first, 1});
    }
    bool doubtful = false;
    OverheadResult seen;
    double last = 0;
    for (int i = 1; i * frame_seconds < end; ++i) {
        const double t = last = i * frame_seconds;
        for (int r = 0; r < 2 && odometry; ++r) tell_wheels(tracker, r, wheels[static_cast<std::size_t>(r)].until(t));
        std::vector<Solid> solids;
        for (const Passage& way : ways) {
            const auto parts = robot_solids(crossing_body, {}, way.at(t));
            solids.insert(solids.end(), parts.begin(), parts.end());
        }
        renderer.render(solids, light_at(t, light), static_cast<std::uint64_t>(i), frame);
        observer.observe(frame, seen);
        tracker.observe(from_seconds(t), camera.id, poses_of(seen.observations));
        one.hidden = std::max(one.hidden, hidden_part(hall.view, ways[0].at(t), ways[1].at(t)));
        doubtful = doubtful || (t > ways[0].meet + 0.5 && in_doubt(tracker, t));
    }
    judge_crossing(tracker, ways, last, doubtful, one.result);
    return one;
}

}  // namespace

CrossingResult render_crossings(int crossings, bool odometry, std::uint64_t seed, double& overlap, const std::function<void(double)>& progress) {
    std::vector<OneCrossing> all(static_cast<std::size_t>(crossings));
    WorkerPool pool(hardware_threads());
    std::atomic<int> done{0};
    pool.run(crossings, [&](int i) {
        all[static_cast<std::size_t>(i)] = cross(odometry, mix64(seed * 104729 + static_cast<std::uint64_t>(i)));
        ++done;
        if (progress) progress(static_cast<double>(done) / crossings);
    });
    CrossingResult sum;
    overlap = 0;
    for (const OneCrossing& one : all) {
        overlap += one.hidden / crossings;
        sum.crossings += one.result.crossings;
        sum.switches += one.result.switches;
        sum.flagged += one.result.flagged;
        sum.false_alarms += one.result.false_alarms;
        sum.lost += one.result.lost;
    }
    return sum;
}

}  // namespace roomfix
