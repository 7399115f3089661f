#include "roomfix/corner/corner_locator.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "roomfix/base/decompositions.hpp"
#include "roomfix/geometry/seen_from_above.hpp"
#include "roomfix/geometry/view.hpp"

namespace roomfix {
namespace {

Eigen::Matrix3d map_from_corner(const SiteCorner& corner) { return Eigen::AngleAxisd(corner.yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix(); }

/// Is the corner hidden from the camera? The walls that meet there do not hide it.
bool hidden(const std::vector<Polyline>& walls, const Eigen::Isometry3d& map_from_camera, const SiteCorner& corner) {
    const Eigen::Vector2d from = map_from_camera.translation().head<2>();
    return wall_between(walls, from, from + 0.97 * (corner.position.head<2>() - from));
}

/// Of the same corner in the picture, taken for the same corner of the site.
bool are_readings(const CameraPlace& a, const CameraPlace& b) { return a.corner == b.corner && a.sighting == b.sighting; }

/// Two corners in one picture that put the camera at the same place speak for that place together; so do a moulding's two, if the site states how far
/// they are apart. If it does not, one of the two was measured: they exclude each other.
void join_same(std::vector<CameraPlace>& places) {
    constexpr double same = 25;  // chi-square of 3
    for (std::size_t i = 0; i < places.size(); ++i) {
        for (std::size_t j = i + 1; j < places.size();) {
            const CameraPlace& a = places[i];
            const CameraPlace& b = places[j];
            const Eigen::Vector3d off(a.pose.x - b.pose.x, a.pose.y - b.pose.y, wrap_angle(a.pose.yaw - b.pose.yaw));
            const bool exclusive = a.observation == b.observation || (are_readings(a, b) && a.depth == b.depth);
            if (exclusive || off.dot((a.covariance + b.covariance).ldlt().solve(off)) > same) {
                ++j;
                continue;
            }
            const double weight = a.weight + b.weight;
            if (b.covariance.topLeftCorner<2, 2>().trace() < a.covariance.topLeftCorner<2, 2>().trace()) places[i] = places[j];
            places[i].weight = weight;
            places.erase(places.begin() + static_cast<std::ptrdiff_t>(j));
        }
    }
}

/// Adds to each place's covariance its distance from the other readings of the same corner, by their weight.
void contain_others(std::vector<CameraPlace>& places) {
    std::vector<Eigen::Matrix3d> spreads;
    for (const CameraPlace& place : places) {
        Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
        double weights = 0;
        for (const CameraPlace& other : places) {
            if (!are_readings(place, other)) continue;
            const Eigen::Vector3d off(other.pose.x - place.pose.x, other.pose.y - place.pose.y, wrap_angle(other.pose.yaw - place.pose.yaw));
            spread += other.weight * off * off.transpose();
            weights += other.weight;
        }
        spreads.push_back(spread / weights);
    }
    Eigen::Matrix<double, 6, 3> by_pose = Eigen::Matrix<double, 6, 3>::Zero();
    by_pose(0, 0) = by_pose(1, 1) = by_pose(5, 2) = 1;
    for (std::size_t i = 0; i < places.size(); ++i) {
        places[i].covariance += spreads[i];
        places[i].map_from_camera.covariance += by_pose * spreads[i] * by_pose.transpose();
    }
}

}  // namespace

Result<CornerLocator> CornerLocator::for_camera(const Site& site, const SiteCamera& camera, const CornerLocatorSettings& settings) {
    CornerLocator locator(site, camera, settings);
    std::string robot;
    double height = 0;
    if (const auto* known = std::get_if<KnownHeight>(&camera.placement)) {
        robot = known->robot;
        height = known->height;
    } else if (const auto* mount = std::get_if<Mount>(&camera.placement)) {
        robot = mount->robot;
        height = mount->robot_from_camera.pose.translation().z();
    } else {
        return Error{fmt::format("camera {} stands still in the map: a camera that looks for corners has 'height' or 'mount'", camera.id)};
    }
    if (site.corners.empty())
        return Error{fmt::format("camera {} looks for corners, but the site has none: measure one and add it under 'corners'", camera.id)};
    for (const SiteCorner& corner : site.corners) {
        if (corner.lower_edge() <= height) {
            return Error{fmt::format("corner {} is {} m high and camera {} is {} m high: the camera must be below the ceiling and its mouldings", corner.id,
                                     corner.position.z(), camera.id, height)};
        }
    }
    locator.robot_ = site.robot(robot).value_or(-1);
    return locator;
}

std::vector<double> CornerLocator::wall_angles() const {
    std::vector<double> angles;
    for (const SiteCorner& corner : site_.corners) {
        const bool known = std::any_of(angles.begin(), angles.end(), [&](double a) { return std::abs(a - corner.wall_angle) < 1e-6; });
        if (!known) angles.push_back(corner.wall_angle);
    }
    return angles;
}

CornerView CornerLocator::view_of(const Eigen::Isometry3d& map_from_camera, const SiteCorner& corner) const {
    const Eigen::Matrix3d corner_from_map = map_from_corner(corner).transpose();
    const Eigen::Vector3d from_corner = corner_from_map * (map_from_camera.translation() - corner.position);
    return {corner_from_map * map_from_camera.linear(), from_corner.head<2>() / -from_corner.z()};
}

CornerHints CornerLocator::expected(const CameraHints& hints) const {
    CornerHints observer;
    const auto* mount = std::get_if<Mount>(&camera_.placement);
    if (mount) {
        const double tilt = std::sqrt(mount->robot_from_camera.covariance(3, 3) + mount->robot_from_camera.covariance(4, 4));
        observer.gravity = Gravity{mount->robot_from_camera.pose.linear().transpose() * -Eigen::Vector3d::UnitZ(),
                                   std::max(mount->has_covariance ? tilt : settings_.unknown_tilt, 0.005)};
    }
    if (!hints.prediction || !mount) return observer;
    const Eigen::Isometry3d map_from_camera = map_from_robot(hints.prediction->pose) * mount->robot_from_camera.pose;
    const View view{camera_.model, {map_from_camera, Matrix6d::Zero()}};
    for (const SiteCorner& measured : site_.corners) {
        SiteCorner corner = measured;
        corner.position.z() = measured.lower_edge();  // where the edge between the walls ends
        const Eigen::Vector2d to_corner = corner.position.head<2>() - map_from_camera.translation().head<2>();
        const auto pixel = project_map_point(view, corner.position);
        if (!pixel || !camera_.model.contains(*pixel, 6) || hidden(site_.walls, map_from_camera, corner)) continue;
        const CornerView seen = view_of(map_from_camera, corner);
        if (!is_inside(seen, corner.wall_angle)) continue;
        const Eigen::Matrix3d& p = hints.prediction->covariance;
        const double angle = std::sqrt(p(2, 2) + (p(0, 0) + p(1, 1)) / std::max(to_corner.squaredNorm(), 0.01));
        observer.expected.push_back({seen, corner.wall_angle, std::max(1.0, camera_.model.fx * angle)});
    }
    return observer;
}

/// A camera of known height: rotation and place are what was seen, scaled by the distance to the ceiling.
std::optional<CameraPlace> CornerLocator::on_tripod(const CornerObservation& seen, const SiteCorner& corner, const KnownHeight& known) const {
    const double distance = corner.position.z() - known.height;
    const Eigen::Matrix3d turn = map_from_corner(corner);
    CameraPlace place;
    Eigen::Isometry3d& pose = place.map_from_camera.pose;
    pose.linear() = turn * seen.view.corner_from_camera;
    const Eigen::Vector3d offset(seen.view.place.x(), seen.view.place.y(), -1);
    pose.translation() = corner.position + turn * (distance * offset);
    // Errors: what was seen (rotation, place), the camera's height, the corner's position.
    Eigen::Matrix<double, 6, 9> by = Eigen::Matrix<double, 6, 9>::Zero();
    by.block<3, 3>(3, 0) = turn;
    by.block<3, 2>(0, 3) = distance * turn.leftCols<2>();
    const Eigen::Vector3d sideways = turn * Eigen::Vector3d(offset.x(), offset.y(), 0);
    by.block<3, 1>(0, 5) = Eigen::Vector3d::UnitZ() - sideways;
    by.block<2, 2>(0, 6) = Eigen::Matrix2d::Identity();
    by.block<3, 1>(0, 8) = sideways;
    Eigen::Matrix<double, 9, 9> errors = Eigen::Matrix<double, 9, 9>::Zero();
    errors.topLeftCorner<5, 5>() = seen.covariance_with(camera_.intrinsics_covariance);
    errors(5, 5) = known.sigma * known.sigma;
    errors.diagonal().tail<3>().setConstant(corner.sigma * corner.sigma);
    place.map_from_camera.covariance = by * errors * by.transpose();

    const PoseFromAbove above = seen_from_above(place.map_from_camera);
    place.pose = above.pose;
    place.yaw_known = above.yaw_known;
    place.covariance = above.covariance;
    return place;
}

/// A camera on a robot: the mount knows its tilt and height, so that three unknowns are left for five measurements.
std::optional<CameraPlace> CornerLocator::on_robot(const CornerObservation& seen, const SiteCorner& corner, const Mount& mount, double& misfit) const {
    const Eigen::Isometry3d& robot_from_camera = mount.robot_from_camera.pose;
    const Eigen::Matrix3d turn = map_from_corner(corner);
    const double distance = corner.position.z() - robot_from_camera.translation().z();
    Matrix6d mount_error = mount.robot_from_camera.covariance;
    if (!mount.has_covariance) {
        mount_error.setZero();
        mount_error.diagonal() << 1e-5, 1e-5, 1e-5, settings_.unknown_tilt * settings_.unknown_tilt, settings_.unknown_tilt * settings_.unknown_tilt, 1e-6;
    }
    const CameraErrors camera_error = joint_covariance(mount_error, camera_.intrinsics_errors());
    // Start: the heading that the seen rotation has, the place that the seen place has.
    const Eigen::Matrix3d map_from_camera = turn * seen.view.corner_from_camera;
    const Eigen::Matrix3d robot = map_from_camera * robot_from_camera.linear().transpose();
    CameraPlace place;
    place.pose.yaw = std::atan2(robot(1, 0), robot(0, 0));
    const Eigen::Vector3d camera = corner.position + turn * (distance * Eigen::Vector3d(seen.view.place.x(), seen.view.place.y(), -1));
    Eigen::Vector3d arm = map_from_robot(place.pose).linear() * robot_from_camera.translation();
    place.pose.x = camera.x() - arm.x();
    place.pose.y = camera.y() - arm.y();
    for (int round = 0; round < 3; ++round) {
        const Eigen::Isometry3d map_from_robot_now = map_from_robot(place.pose);
        const CornerView predicted = view_of(map_from_robot_now * robot_from_camera, corner);
        Vector5d off;
        off.head<3>() = rotation_vector(seen.view.corner_from_camera * predicted.corner_from_camera.transpose());
        off.tail<2>() = seen.view.place - predicted.place;
        arm = map_from_robot_now.linear() * robot_from_camera.translation();
        const Eigen::Matrix<double, 2, 3> place_by_map = turn.leftCols<2>().transpose() / distance;
        Eigen::Matrix<double, 5, 3> by_pose = Eigen::Matrix<double, 5, 3>::Zero();
        by_pose(2, 2) = 1;
        by_pose.block<2, 2>(3, 0) = place_by_map.leftCols<2>();
        by_pose.block<2, 1>(3, 2) = place_by_map * Eigen::Vector3d::UnitZ().cross(arm);
        // The mount's error, fixed axes of the robot: it moves the camera and turns it. Raising the camera shortens the distance.
        Eigen::Matrix<double, 5, camera_errors> by_camera = Eigen::Matrix<double, 5, camera_errors>::Zero();
        auto by_mount = by_camera.leftCols<6>();
        by_mount.block<3, 3>(0, 3) = turn.transpose() * map_from_robot_now.linear();
        by_mount.block<2, 3>(3, 0) = place_by_map * map_from_robot_now.linear();
        by_mount.block<2, 1>(3, 2) += predicted.place / distance;
        Eigen::Matrix<double, 5, 3> by_corner = Eigen::Matrix<double, 5, 3>::Zero();
        by_corner.block<2, 2>(3, 0) = -place_by_map.leftCols<2>();
        by_corner.block<2, 1>(3, 2) = -predicted.place / distance;
        by_camera.rightCols<most_intrinsics>() = -seen.by_intrinsics;
        const Matrix5d noise =
            seen.covariance + by_camera * camera_error * by_camera.transpose() + corner.sigma * corner.sigma * by_corner * by_corner.transpose();
        const Eigen::LLT<Matrix5d> noise_solver(noise);
        const Eigen::Matrix3d information = by_pose.transpose() * noise_solver.solve(by_pose);
        const Eigen::Vector3d move = information.ldlt().solve(by_pose.transpose() * noise_solver.solve(off));
        if (!move.allFinite()) return std::nullopt;
        place.pose.x += move.x();
        place.pose.y += move.y();
        place.pose.yaw = wrap_angle(place.pose.yaw + move.z());
        place.covariance = information.inverse();
        const Vector5d left = off - by_pose * move;
        misfit = left.dot(noise_solver.solve(left));
    }
    place.map_from_camera.pose = map_from_robot(place.pose) * robot_from_camera;
    const Eigen::Matrix3d turned = map_from_robot(place.pose).linear();
    Eigen::Matrix<double, 6, 3> by = Eigen::Matrix<double, 6, 3>::Zero();
    by(0, 0) = by(1, 1) = by(5, 2) = 1;
    by.block<3, 1>(0, 2) = Eigen::Vector3d::UnitZ().cross(turned * robot_from_camera.translation());
    Matrix6d turned_mount = Matrix6d::Zero();
    turned_mount.topLeftCorner<3, 3>() = turned * camera_error.topLeftCorner<3, 3>() * turned.transpose();
    turned_mount.bottomRightCorner<3, 3>() = turned * camera_error.block<3, 3>(3, 3) * turned.transpose();
    place.map_from_camera.covariance = by * place.covariance * by.transpose() + turned_mount;
    return place;
}

double CornerLocator::height() const {
    if (const auto* known = std::get_if<KnownHeight>(&camera_.placement)) return known->height;
    return std::get<Mount>(camera_.placement).robot_from_camera.pose.translation().z();
}

std::optional<CameraPlace> CornerLocator::stand_at(const CornerObservation& seen, const SiteCorner& corner, double& misfit) const {
    misfit = 0;
    if (const auto* known = std::get_if<KnownHeight>(&camera_.placement)) return on_tripod(seen, corner, *known);
    return on_robot(seen, corner, std::get<Mount>(camera_.placement), misfit);
}

/// Logarithm, up to a constant.
double CornerLocator::hint_likelihood(const CameraPlace& place, const CameraHints& hints) const {
    double log = 0;
    if (hints.heading && place.yaw_known) {
        const double off = wrap_angle(std::atan2(place.map_from_camera.pose.linear()(1, 2), place.map_from_camera.pose.linear()(0, 2)) - hints.heading->yaw);
        log -= 0.5 * off * off / (hints.heading->sigma * hints.heading->sigma);
    }
    if (hints.prediction) {
        const Pose2& expected = hints.prediction->pose;
        const Eigen::Vector3d off(place.pose.x - expected.x, place.pose.y - expected.y, wrap_angle(place.pose.yaw - expected.yaw));
        const Eigen::Matrix3d spread = hints.prediction->covariance + place.covariance;
        log -= 0.5 * off.dot(spread.ldlt().solve(off));
    }
    if (robot_ >= 0 && site_.robots[static_cast<std::size_t>(robot_)].receiver()) {
        const Eigen::Vector3d receiver = map_from_robot(place.pose) * site_.robots[static_cast<std::size_t>(robot_)].receiver()->position;
        for (const RangeObservation& range : hints.ranges) {
            const double known = (site_.beacons[static_cast<std::size_t>(range.beacon)].position - receiver).norm();
            const double sigma = std::sqrt(range.sigma * range.sigma + place.covariance(0, 0) + place.covariance(1, 1));
            log += range_likelihood(range.range - known, sigma, settings_.late).log_density;
        }
    }
    return log;
}

void CornerLocator::locate(std::span<const CornerObservation> seen, const CameraHints& hints, LocatedCamera& result) const {
    result.places.clear();
    result.best_corner = 0;
    result.reason.clear();
    std::vector<double> scores;
    bool behind_walls = false;
    for (std::size_t o = 0; o < seen.size(); ++o) {
        for (std::size_t c = 0; c < site_.corners.size(); ++c) {
            const SiteCorner& corner = site_.corners[c];
            if (hints.corner >= 0 && hints.corner != static_cast<int>(c)) continue;
            if (std::abs(corner.wall_angle - seen[o].wall_angle) > 1e-6) continue;
            for (const CornerReading& reading : readings_of(seen[o], corner.moulding, corner.position.z() - height())) {
                double misfit = 0;
                auto place = stand_at(reading.seen, corner, misfit);
                if (!place || misfit > settings_.largest_misfit) continue;
                if (hidden(site_.walls, place->map_from_camera.pose, corner)) {
                    behind_walls = true;
                    continue;
                }
                place->corner = static_cast<int>(c);
                place->observation = static_cast<int>(o);
                place->sighting = seen[o].sighting;
                place->depth = reading.depth;
                scores.push_back(std::log(seen[o].weight * reading.weight) - 0.5 * misfit + hint_likelihood(*place, hints));
                result.places.push_back(*place);
            }
        }
    }
    if (result.places.empty()) {
        if (!seen.empty()) {
            result.reason = behind_walls ? "a corner is seen, but from any corner of the site the camera would stand behind a wall"
                                         : "a corner is seen, but it fits none of the site's: check their heights, angles and the camera's mount";
        }
        return;
    }
    const double best = *std::max_element(scores.begin(), scores.end());
    double sum = 0;
    for (std::size_t i = 0; i < scores.size(); ++i) sum += result.places[i].weight = std::exp(scores[i] - best);
    std::erase_if(result.places, [&](const CameraPlace& p) { return p.weight < settings_.least_weight * sum; });
    join_same(result.places);
    std::stable_sort(result.places.begin(), result.places.end(), [](const CameraPlace& a, const CameraPlace& b) { return a.weight > b.weight; });
    double kept = 0;
    for (const CameraPlace& p : result.places) kept += p.weight;
    for (CameraPlace& p : result.places) {
        p.weight /= kept;
        if (are_readings(p, result.places[0])) result.best_corner += p.weight;
    }
    contain_others(result.places);
}

}  // namespace roomfix
