#include "roomfix/overhead/robot_tag.hpp"

#include <Eigen/Geometry>
#include <cmath>

#include "roomfix/base/decompositions.hpp"

namespace roomfix {
namespace {

struct Linearised {
    Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
    Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
    Eigen::Matrix<double, 3, 6> by_calibration = Eigen::Matrix<double, 3, 6>::Zero();
    double squares = 0;
};

std::optional<Linearised> linearise(const View& view, const SiteRobot& robot, const std::array<Eigen::Vector2d, 4>& corners, const Pose2& pose) {
    Linearised l;
    const auto own = own_points(*robot.tag);
    for (std::size_t i = 0; i < 4; ++i) {
        const Eigen::Vector3d in_robot = robot.robot_from_tag * own[i];
        const Eigen::Vector3d in_map = map_from_robot(pose) * in_robot;
        ViewJacobian j;
        const auto pixel = project_map_point(view, in_map, &j);
        if (!pixel) return std::nullopt;
        Eigen::Matrix<double, 2, 3> by_pose;
        by_pose.leftCols<2>() = j.by_point.leftCols<2>();
        by_pose.col(2) = j.by_point * Eigen::Vector3d::UnitZ().cross(in_map - Eigen::Vector3d(pose.x, pose.y, 0));
        const Eigen::Vector2d residual = corners[i] - *pixel;
        l.information += by_pose.transpose() * by_pose;
        l.gradient += by_pose.transpose() * residual;
        l.by_calibration += j.by_calibration(view, Eigen::Matrix<double, 3, 2>(by_pose.transpose()));
        l.squares += residual.squaredNorm();
    }
    return l;
}

/// Where the corners' rays meet the plane of the tag: the middle is the tag's place, its lower edge the direction.
std::optional<Pose2> start_of(const View& view, const SiteRobot& robot, const std::array<Eigen::Vector2d, 4>& corners) {
    const double height = robot.robot_from_tag.translation().z();
    Eigen::Vector2d middle = Eigen::Vector2d::Zero();
    std::array<Eigen::Vector2d, 4> places;
    for (std::size_t i = 0; i < 4; ++i) {
        const auto place = pixel_to_plane(view, corners[i], height);
        if (!place) return std::nullopt;
        places[i] = place->point;
        middle += place->point / 4;
    }
    const Eigen::Vector2d right = places[1] - places[0] + places[2] - places[3];
    const Eigen::Vector3d own_right = robot.robot_from_tag.linear().col(0);
    const double yaw = std::atan2(right.y(), right.x()) - std::atan2(own_right.y(), own_right.x());
    const Eigen::Vector2d offset = Eigen::Rotation2Dd(yaw) * robot.robot_from_tag.translation().head<2>();
    return Pose2{middle.x() - offset.x(), middle.y() - offset.y(), yaw};
}

}  // namespace

std::optional<RobotTagFit> fit_robot_tag(const View& view, const SiteRobot& robot, const std::array<Eigen::Vector2d, 4>& corners, double sigma,
                                         double largest_rms) {
    const auto start = start_of(view, robot, corners);
    if (!start) return std::nullopt;
    Pose2 pose = *start;
    for (int round = 0; round < 10; ++round) {
        const auto at = linearise(view, robot, corners, pose);
        if (!at) return std::nullopt;
        const Eigen::Vector3d step = at->information.ldlt().solve(at->gradient);
        if (!step.allFinite()) return std::nullopt;
        pose = {pose.x + step.x(), pose.y + step.y(), pose.yaw + step.z()};
        if (step.norm() < 1e-10) break;
    }
    const auto at = linearise(view, robot, corners, pose);
    const Eigen::LLT<Eigen::Matrix3d> factor(at ? at->information : Eigen::Matrix3d::Zero());
    if (!at || factor.info() != Eigen::Success) return std::nullopt;
    RobotTagFit fit;
    fit.pixel_rms = std::sqrt(at->squares / 8);
    if (!(fit.pixel_rms < largest_rms)) return std::nullopt;
    fit.pose = {pose.x, pose.y, wrap_angle(pose.yaw)};
    const Eigen::Matrix3d own = factor.solve(Eigen::Matrix3d::Identity());
    fit.by_calibration = own * at->by_calibration;
    fit.covariance = sigma * sigma * own + fit.by_calibration * fit.by_calibration.transpose();
    return fit;
}

std::vector<TaggedRobot> find_tagged_robots(const View& view, const std::vector<SiteRobot>& robots, TagDetector& detector, LumaView frame) {
    std::vector<SeenTag> tags;
    detector.detect(frame, tags);
    std::vector<TaggedRobot> found;
    for (const SeenTag& tag : tags) {
        for (std::size_t r = 0; r < robots.size(); ++r) {
            if (!robots[r].tag || !robots[r].tag->is(tag.family, tag.number)) continue;
            const double sigma = detector.settings().corner_sigma;
            const auto fit = fit_robot_tag(view, robots[r], tag.corners, sigma);
            if (fit) found.push_back({static_cast<int>(r), *fit, tag.corners, sigma});
        }
    }
    return found;
}

}  // namespace roomfix
