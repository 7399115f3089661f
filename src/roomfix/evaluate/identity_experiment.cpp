#include "roomfix/evaluate/identity_experiment.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "roomfix/base/random.hpp"
#include "roomfix/base/random_vector.hpp"
#include "roomfix/evaluate/crossing.hpp"

namespace roomfix {
namespace {

PoseObservation observed(const Pose2& at, double sigma, double yaw_sigma, int robot, Random& random) {
    PoseObservation o;
    o.robot = robot;
    o.like_turns = 4;
    o.pose = {at.x + random.normal(sigma), at.y + random.normal(sigma),
              wrap_angle(at.yaw + random.normal(yaw_sigma) + 0.5 * std::numbers::pi * random.index(4))};
    o.covariance = Eigen::Vector3d(sigma * sigma, sigma * sigma, yaw_sigma * yaw_sigma).asDiagonal();
    return o;
}

void cross(bool odometry, std::uint64_t seed, CrossingResult& result) {
    Random random(seed);
    Site site;
    site.robots = like_robots(odometry);
    Tracker tracker(site);
    const std::array<Passage, 2> ways = random_passages(0.25 * crossing_body.width, random);
    auto wheels = wheels_of(ways, random);
    // Their names are told once, as a tag or a person would.
    for (int r = 0; r < 2; ++r) {
        PoseObservation first = observed(ways[static_cast<std::size_t>(r)].at(0), 0.01, 0.02, r, random);
        first.like_turns = 1;
        first.pose.yaw = ways[static_cast<std::size_t>(r)].at(0).yaw;
        first.identified = true;
        tracker.observe(from_seconds(0.0), r == 0 ? "door 1" : "door 2", {&first, 1});
    }
    constexpr double end = 8;
    bool doubtful = false;
    for (int i = 1; i * 0.1 < end; ++i) {
        const double t = i * 0.1;
        for (int r = 0; r < 2 && odometry; ++r) tell_wheels(tracker, r, wheels[static_cast<std::size_t>(r)].until(t));
        const std::array<Pose2, 2> now = {ways[0].at(t), ways[1].at(t)};
        const bool overlap = std::abs(now[0].x - now[1].x) < crossing_body.length;
        std::vector<PoseObservation> frame;
        for (int r = 0; r < 2; ++r) {
            if (overlap && random.uniform() < 0.3) continue;
            frame.push_back(observed(now[static_cast<std::size_t>(r)], overlap ? 0.04 : 0.01, overlap ? 0.1 : 0.02, 0, random));
        }
        if (random.uniform() < 0.5) std::reverse(frame.begin(), frame.end());
        tracker.observe(from_seconds(t), "hall", frame);
        doubtful = doubtful || (t > ways[0].meet + 0.5 && in_doubt(tracker, t));
    }
    judge_crossing(tracker, ways, end - 0.1, doubtful, result);
}

/// The places that a corner leaves open: one for each corner that it may be.
std::vector<PlaceProposal> places_at_corners(const Site& site, const CornerObservation& seen, const Eigen::Isometry3d& robot_from_camera) {
    std::vector<PlaceProposal> places;
    for (const SiteCorner& corner : site.corners) {
        const Eigen::Matrix3d map_from_corner = Eigen::AngleAxisd(corner.yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
        const Eigen::Matrix3d map_from_camera = map_from_corner * seen.view.corner_from_camera;
        const double below = corner.position.z() - robot_from_camera.translation().z();
        const Eigen::Vector3d camera = corner.position + map_from_corner * Eigen::Vector3d(below * seen.view.place.x(), below * seen.view.place.y(), -below);
        const Eigen::Matrix3d map_from_robot_turn = map_from_camera * robot_from_camera.linear().transpose();
        const double yaw = std::atan2(map_from_robot_turn(1, 0), map_from_robot_turn(0, 0));
        const Eigen::Vector3d at = camera - Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) * robot_from_camera.translation();
        places.push_back({{at.x(), at.y(), yaw}, Eigen::Vector3d(9e-4, 9e-4, 4e-4).asDiagonal(), true, 1});
    }
    return places;
}

bool wake_among_corners(std::uint64_t seed, bool& at_once) {
    Random random(seed);
    constexpr double length = 6, width = 4.5, height = 2.7;
    Site site;
    site.robots = {wheeled_robot("r1")};
    Receiver receiver;
    receiver.position = Eigen::Vector3d(0, 0, 0.4);
    receiver.sigma = 0.03;
    site.robots[0].receivers = {receiver};
    SiteBeacon beacon;
    beacon.id = "b";
    beacon.position = Eigen::Vector3d(1.2, 0, 2.2);
    site.beacons.push_back(beacon);
    for (int i = 0; i < 4; ++i) {
        SiteCorner corner;
        corner.id = std::to_string(i);
        corner.position = Eigen::Vector3d(i == 1 || i == 2 ? length : 0, i >= 2 ? width : 0, height);
        corner.yaw = i * std::numbers::pi / 2;
        site.corners.push_back(corner);
    }
    SiteCamera eye;
    eye.id = "eye";
    eye.model = make_camera_model(640, 480, 330, 330, 320, 240);
    Mount& mount = eye.placement.emplace<Mount>();
    mount.robot = "r1";
    mount.robot_from_camera.pose = looking_at(Eigen::Vector3d(0, 0, 0.3), {1, 0, 0.9});
    site.cameras.push_back(eye);
    Tracker tracker(site);

    // Two metres, straight on, in a direction with room for them.
    Pose2 start;
    for (bool fits = false; !fits;) {
        start = {random.uniform(0.8, length - 0.8), random.uniform(0.8, width - 0.8), random.uniform(-std::numbers::pi, std::numbers::pi)};
        const double x = start.x + 2.2 * std::cos(start.yaw), y = start.y + 2.2 * std::sin(start.yaw);
        fits = x > 0.6 && y > 0.6 && x < length - 0.6 && y < width - 0.6;
    }
    constexpr double speed = 0.4;
    const double end = 2 / speed;
    const auto truth = [&](double t) { return Pose2{start.x + speed * t * std::cos(start.yaw), start.y + speed * t * std::sin(start.yaw), start.yaw}; };
    const std::uint64_t wheels_seed = random.bits();
    WheelSimulator wheels(random_wheels(random), truth, wheels_seed);
    const LateModel late;
    bool first = true;
    for (int i = 0; i * 0.1 <= end; ++i) {
        const double t = i * 0.1;
        tell_wheels(tracker, 0, wheels.until(t + 1e-9));
        const Eigen::Isometry3d map_from_camera = map_from_robot(truth(t)) * mount.robot_from_camera.pose;
        for (const SiteCorner& corner : site.corners) {
            const auto pixel = project(eye.model, map_from_camera.inverse() * corner.position);
            if (!pixel || !eye.model.contains(*pixel, 20)) continue;
            const Eigen::Matrix3d corner_from_map = Eigen::AngleAxisd(-corner.yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
            const Eigen::Vector3d at = corner_from_map * (map_from_camera.translation() - corner.position);
            CornerObservation seen;
            constexpr double sigma = 0.004;
            seen.covariance = sigma * sigma * Matrix5d::Identity();
            seen.view.corner_from_camera =
                exponential_rotation({random.normal(sigma), random.normal(sigma), random.normal(sigma)}) * corner_from_map * map_from_camera.linear();
            seen.view.place = at.head<2>() / -at.z() + normal2(random, sigma);
            tracker.observe(from_seconds(t), "eye", CornerSighting{0, {seen}, places_at_corners(site, seen, mount.robot_from_camera.pose)});
            break;
        }
        double range = (map_from_robot(truth(t)) * receiver.position - beacon.position).norm() + random.normal(receiver.sigma);
        if (random.uniform() < late.share) range -= late.mean * std::log(random.uniform());
        if (i % 2 == 0) tracker.observe(RangeObservation{from_seconds(t), 0, 0, range, receiver.sigma});
        const auto right = [&] {
            const Track* track = tracker.track(0);
            return track && std::hypot(track->belief.best().mean[0] - truth(t).x, track->belief.best().mean[1] - truth(t).y) < 0.3;
        };
        if (first && tracker.track(0)) {
            at_once = right();
            first = false;
        }
    }
    const Fix last = named_fix(tracker.fixes(from_seconds(end)), "r1");
    return last.status != FixStatus::none && distance(last, truth(end)) < 0.3;
}

}  // namespace

CrossingResult simulate_crossings(int crossings, bool odometry, std::uint64_t seed) {
    CrossingResult result;
    for (int i = 0; i < crossings; ++i) cross(odometry, mix64(seed * 1009 + static_cast<std::uint64_t>(i)), result);
    return result;
}

CornerChoiceResult choose_among_corners(int runs, std::uint64_t seed) {
    CornerChoiceResult result;
    for (int i = 0; i < runs; ++i) {
        bool at_once = false;
        result.right += wake_among_corners(mix64(seed * 2003 + static_cast<std::uint64_t>(i)), at_once);
        result.right_at_once += at_once;
        ++result.runs;
    }
    return result;
}

KidnappingResult simulate_kidnappings(int runs, std::uint64_t seed) {
    KidnappingResult result;
    for (int i = 0; i < runs; ++i) {
        Random random(mix64(seed * 3001 + static_cast<std::uint64_t>(i)));
        Site site;
        site.robots = {wheeled_robot("r1")};
        Tracker tracker(site);
        const auto place = [&] { return Pose2{random.uniform(0, 10), random.uniform(0, 10), random.uniform(-3, 3)}; };
        const Pose2 from = place();
        const Pose2 to = place();
        constexpr double carried = 6, seen_again = 8;
        const double rate = random.uniform(2, 20);
        const std::uint64_t wheels_seed = random.bits();
        WheelSimulator wheels(
            random_wheels(random), [&](double) { return from; }, wheels_seed);
        ++result.runs;
        double found = -1;
        for (double t = 0; t < seen_again + 3; t += 1 / rate) {
            tell_wheels(tracker, 0, wheels.until(t));
            if (t > carried && t < seen_again) continue;
            const Pose2& now = t < carried ? from : to;
            const PoseObservation o = observed(now, 0.015, 0.03, 0, random);
            tracker.observe(from_seconds(t), "hall", {&o, 1});
            const Fix fix = named_fix(tracker.fixes(from_seconds(t)), "r1");
            if (found < 0 && t >= seen_again && fix.status == FixStatus::ok && distance(fix, to) < 0.1) found = t - seen_again;
        }
        if (found < 0 || found > 2) continue;
        ++result.found;
        result.longest = std::max(result.longest, found);
    }
    return result;
}

}  // namespace roomfix
