#include "roomfix/evaluate/hall.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "roomfix/base/random_vector.hpp"

namespace roomfix {
namespace {

const Eigen::Vector2d hall(8, 6);  // m
constexpr double hall_height = 3;

CameraModel wall_camera_model() { return make_camera_model(640, 480, 420, 420, 320, 240); }

}  // namespace

Site hall_site(const HallSenses& senses) {
    Site site;
    site.name = "hall";
    site.ceiling = hall_height;
    for (int c = 0; c < 2; ++c) {
        SiteCamera camera;
        camera.id = c == 0 ? "west" : "east";
        camera.model = wall_camera_model();
        const Eigen::Vector3d at(c == 0 ? 0.1 : hall.x() - 0.1, c == 0 ? 0.5 : hall.y() - 0.5, 2.6);
        KnownPose known;
        known.map_from_camera.pose = looking_at(at, {hall.x() * (c == 0 ? 0.45 : 0.55), hall.y() / 2, 0});
        Vector6d sigma;
        sigma << 0.01, 0.01, 0.01, 0.003, 0.003, 0.003;
        known.map_from_camera.covariance = sigma.cwiseAbs2().asDiagonal();
        camera.placement.emplace<KnownPose>(known);
        site.cameras.push_back(camera);
    }
    const auto mounted = [&](const char* id, const Eigen::Matrix3d& turn, const CameraModel& model) {
        SiteCamera camera;
        camera.id = id;
        camera.model = model;
        Mount mount;
        mount.robot = "r1";
        mount.has_covariance = true;
        mount.robot_from_camera.pose.linear() = turn;
        mount.robot_from_camera.pose.translation() = Eigen::Vector3d(0.05, 0, 0.3);
        Vector6d sigma;
        sigma << 0.002, 0.002, 0.002, 0.003, 0.003, 0.003;
        mount.robot_from_camera.covariance = sigma.cwiseAbs2().asDiagonal();
        camera.placement.emplace<Mount>(mount);
        site.cameras.push_back(camera);
    };
    Eigen::Matrix3d up;
    up << 0, -1, 0, 1, 0, 0, 0, 0, 1;
    mounted("up", up, make_camera_model(352, 288, 300, 300, 175.5, 143.5));
    mounted("eye", looking_at(Eigen::Vector3d::Zero(), {1, 0, 0.6}).linear(), make_camera_model(640, 480, 330, 330, 320, 240));
    SiteRobot robot;
    robot.id = "r1";
    robot.shape = Box{0.6, 0.4, 0.4};
    // Where nothing shows the front, the wheels may point anywhere.
    const bool has_front = senses.cameras || senses.ceiling || senses.corners || senses.odometry;
    robot.drive = has_front ? Drive::differential : Drive::holonomic;
    robot.odometry = WheelOdometry{};
    Receiver receiver;
    receiver.position = Eigen::Vector3d(has_front ? 0.1 : 0, 0, 0.4);
    receiver.sigma = 0.03;
    robot.receivers = {receiver};
    site.robots.push_back(robot);
    int number = 0;
    for (double x = 0.5; x < hall.x(); x += 1.4) {
        for (double y = 0.5; y < hall.y(); y += 1.25) {
            SiteLandmark landmark;
            landmark.id = fmt::format("n{}", ++number);
            landmark.kind = LedTriangle{0.10, 0.15};
            landmark.map_from_landmark.translation() = Eigen::Vector3d(x, y, hall_height);
            site.landmarks.push_back(landmark);
        }
    }
    for (const Eigen::Vector2d& at : {Eigen::Vector2d(0, 0), {8, 0}, {8, 6}, {0, 6}, {4, 0}, {4, 6}}) {
        SiteBeacon beacon;
        beacon.id = fmt::format("b{}", site.beacons.size());
        beacon.position = Eigen::Vector3d(at.x(), at.y(), 2.5);
        site.beacons.push_back(beacon);
    }
    for (int i = 0; i < 4; ++i) {
        SiteCorner corner;
        corner.id = fmt::format("c{}", i);
        corner.position = Eigen::Vector3d(i == 1 || i == 2 ? hall.x() : 0, i >= 2 ? hall.y() : 0, hall_height);
        corner.yaw = i * std::numbers::pi / 2;
        site.corners.push_back(corner);
    }
    return site;
}

namespace {

StateVector next_state(const StateVector& now, const MotionModel& model, Random& random) {
    const Eigen::Rotation2Dd axes(now[state_yaw]);
    Eigen::Vector2d own = axes.inverse() * now.segment<2>(state_vx);
    const double keep = std::exp(-TrueMotion::step / model.memory);
    const double root = std::sqrt(TrueMotion::step);
    own.x() = keep * own.x() + random.normal(model.acceleration * root);
    const bool steers = model.drive == Drive::differential;
    own.y() = keep * (steers ? std::exp(-TrueMotion::step / model.slip_memory) : 1) * own.y() +
              random.normal((steers ? model.side_acceleration : model.acceleration) * root);
    StateVector next = now;
    next[state_turn] = keep * now[state_turn] + random.normal(model.turning * root);
    next[state_yaw] += 0.5 * TrueMotion::step * (now[state_turn] + next[state_turn]);
    const Eigen::Vector2d velocity = Eigen::Rotation2Dd(next[state_yaw]) * own;
    next.head<2>() += 0.5 * TrueMotion::step * (now.segment<2>(state_vx) + velocity);
    next.segment<2>(state_vx) = velocity;
    return next;
}

}  // namespace

StateVector TrueMotion::at(double time) const { return states[std::min(static_cast<std::size_t>(std::lround(time / step)), states.size() - 1)]; }

TrueMotion drive_through_hall(double seconds, const MotionModel& model, Random& random) {
    TrueMotion motion;
    StateVector now = StateVector::Zero();
    now.head<3>() = uniform3(random, {2.5, 2, -3}, {5.5, 4, 3});
    now.segment<2>(state_vx) = Eigen::Rotation2Dd(now[state_yaw]) * Eigen::Vector2d(random.uniform(0.1, 0.5), 0);
    motion.states.push_back(now);
    const auto steps = static_cast<std::size_t>(seconds / TrueMotion::step) + 1;
    constexpr std::size_t stretch = 200;
    int attempts = 0;
    while (motion.states.size() < steps) {
        const std::size_t before = motion.states.size();
        bool inside = true;
        for (std::size_t i = 0; i < stretch && inside; ++i) {
            motion.states.push_back(next_state(motion.states.back(), model, random));
            const auto& s = motion.states.back();
            inside = s[0] > 0.8 && s[1] > 0.8 && s[0] < hall.x() - 0.8 && s[1] < hall.y() - 0.8 && s.segment<2>(state_vx).norm() < 1.5 &&
                     std::abs(s[state_turn]) < 3;
        }
        if (inside) continue;
        // Stuck in front of a wall: go back farther.
        const std::size_t back = before - std::min<std::size_t>(before - 1, stretch * static_cast<std::size_t>(++attempts / 20));
        motion.states.resize(attempts % 20 == 0 ? back : before);
    }
    return motion;
}

}  // namespace roomfix
