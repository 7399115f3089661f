#include "roomfix/calibrate/floor.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "roomfix/base/decompositions.hpp"
#include "roomfix/base/levenberg_marquardt.hpp"
#include "roomfix/base/random.hpp"
#include "roomfix/geometry/floor_points.hpp"

namespace roomfix {
namespace {

constexpr double rival_margin = 16;  // of a chi-square: a pose that explains everything so much worse is another one
constexpr double doubt_from = 3;     // standard deviations from which on an outlier loses its weight

/// What one source says at a pose.
struct Linearised {
    Matrix6d information = Matrix6d::Zero();
    Vector6d gradient = Vector6d::Zero();
    PoseByIntrinsics by_intrinsics = PoseByIntrinsics::Zero();                   // J^T W d(pixels)/d(intrinsics)
    Vector6d by_scale = Vector6d::Zero();                                        // J^T W d(pixels)/d(scale)
    Eigen::Matrix<double, 6, 2> by_place = Eigen::Matrix<double, 6, 2>::Zero();  // J^T W d(pixels)/d(map)
    double cost = 0;
    double squares = 0;  // weighted
    double weights = 0;  // of the sightings, 0..1 each
    double rows = 0;     // numbers measured
    double pixels = 0;   // squared, px^2, of the measured directions
    bool visible = true;
};

/// Of a point, not only across a line.
bool tells_both_directions(const FloorSighting& sighting) { return sighting.information.determinant() > 1e-9 * sighting.information.squaredNorm(); }

void add_sighting(const View& view, const FloorSource& source, const FloorSighting& sighting, Linearised& l) {
    ViewJacobian j;
    const Eigen::Vector3d point(sighting.map.x(), sighting.map.y(), 0);
    const auto pixel = project_map_point(view, point, &j);
    IntrinsicsJacobian by_intrinsics;
    if (!pixel || !project(view.model, view.map_from_camera.pose.inverse() * point, nullptr, &by_intrinsics)) {
        l.visible = false;
        return;
    }
    const Eigen::Vector2d r = sighting.pixel - *pixel;
    const double square = r.dot(sighting.information * r);
    const double rank = tells_both_directions(sighting) ? 2 : 1;
    double weight = 1;
    double cost = square;
    if (source.outliers) {  // Geman and McClure
        const double limit = doubt_from * doubt_from;
        weight = std::pow(limit / (limit + square), 2);
        cost = limit * square / (limit + square);
    }
    const Eigen::Matrix<double, 6, 2> back = weight * j.by_pose.transpose() * sighting.information;
    l.information += back * j.by_pose;
    l.gradient += back * r;
    l.by_intrinsics += back * by_intrinsics;
    l.by_place += back * j.by_point.leftCols<2>();
    l.by_scale += back * j.by_point.leftCols<2>() * (sighting.map - source.about);
    l.cost += cost;
    l.squares += weight * square;
    l.weights += weight;
    l.rows += weight * rank;
    const double sharp = sighting.information.norm();
    l.pixels += weight * square / std::max(sharp, 1e-300);
}

Linearised linearise(const View& view, const FloorSource& source) {
    Linearised l;
    for (const FloorSighting& s : source.sightings) add_sighting(view, source, s, l);
    if (!source.pose) return l;
    const Matrix6d weight = source.pose->covariance.inverse();
    const Vector6d r = error_between(view.map_from_camera.pose, source.pose->pose);
    l.information += weight;
    l.gradient += weight * r;
    l.cost += r.dot(weight * r);
    l.squares += r.dot(weight * r);
    l.rows += 6;
    return l;
}

std::vector<Linearised> linearise(const View& view, const std::vector<FloorSource>& sources) {
    std::vector<Linearised> all;
    for (const FloorSource& source : sources) all.push_back(linearise(view, source));
    return all;
}

template <class Part>
auto sum_of(const std::vector<Linearised>& all, const Part& part) {
    auto sum = part(all.front());
    for (std::size_t i = 1; i < all.size(); ++i) sum += part(all[i]);
    return sum;
}

bool visible(const std::vector<Linearised>& all) {
    return std::all_of(all.begin(), all.end(), [](const Linearised& l) { return l.visible; });
}

bool fixes_pose(const Matrix6d& information) {
    const Vector6d scale = information.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
    const Matrix6d unit = scale.asDiagonal() * information * scale.asDiagonal();
    return symmetric_eigen(unit).eigenvalues()[0] > 1e-10;
}

/// What errors add that all sightings of a source share; `own`: covariance of the pose without them.
Matrix6d common_errors(const FloorSource& source, const Linearised& l, const Matrix6d& own) {
    const Vector6d by_scale = source.scale_sigma * own * l.by_scale;
    const Eigen::Matrix<double, 6, 2> by_place = source.place_sigma * own * l.by_place;
    return by_scale * by_scale.transpose() + by_place * by_place.transpose();
}

/// Levenberg-Marquardt on the camera's pose.
std::vector<Linearised> refine(View& view, const std::vector<FloorSource>& sources) {
    auto at = linearise(view, sources);
    if (!visible(at)) return at;
    levenberg_marquardt({.least = 1e-12, .most = 1e12}, [&](double damping) {
        const Matrix6d information = sum_of(at, [](const Linearised& l) { return l.information; });
        const Vector6d gradient = sum_of(at, [](const Linearised& l) { return l.gradient; });
        const Vector6d step = damped_step(information, gradient, damping);
        View moved = view;
        moved.map_from_camera.pose = perturbed(view.map_from_camera.pose, step);
        auto next = linearise(moved, sources);
        const auto cost = [](const Linearised& l) { return l.cost; };
        if (!visible(next) || !(sum_of(next, cost) <= sum_of(at, cost))) return StepResult::worse;
        view = moved;
        at = std::move(next);
        return step.norm() < 1e-12 ? StepResult::settled : StepResult::better;
    });
    return at;
}

/// The mean square of the pose's error, given these sightings, where it is not normal: a few clicks on a small tile leave the camera on a
/// curve. `own`: the covariance as far as it is normal. Importance sampling from a t distribution; the same sightings give the same numbers.
/// Nothing where it is not needed: many points leave no room for curves.
std::optional<Matrix6d> curved_covariance(const View& view, const std::vector<FloorSource>& sources, const Matrix6d& own) {
    constexpr std::size_t few = 12;
    std::size_t count = 0;
    for (const FloorSource& source : sources) count += source.sightings.size();
    if (count == 0 || count > few) return std::nullopt;
    constexpr int samples = 4000;
    constexpr int freedom = 5;     // of the t distribution
    constexpr double wider = 1.2;  // than what is normal
    Random random(1);
    const Matrix6d root = wider * Matrix6d(own.llt().matrixL());
    const double least = sum_of(linearise(view, sources), [](const Linearised& l) { return l.cost; });
    Matrix6d sum = Matrix6d::Zero();
    double weights = 0, largest = 0;
    for (int i = 0; i < samples; ++i) {
        Vector6d normal;
        for (int k = 0; k < 6; ++k) normal[k] = random.normal(1);
        double chi = 0;
        for (int k = 0; k < freedom; ++k) chi += std::pow(random.normal(1), 2);
        const Vector6d scaled = normal * std::sqrt(freedom / chi);
        const Vector6d error = root * scaled;
        View other = view;
        other.map_from_camera.pose = perturbed(view.map_from_camera.pose, error);
        const auto there = linearise(other, sources);
        if (!visible(there)) continue;
        const double cost = sum_of(there, [](const Linearised& l) { return l.cost; }) - least;
        const double log_drawn = -0.5 * (freedom + 6) * std::log1p(scaled.squaredNorm() / freedom);
        const double weight = std::exp(-0.5 * cost - log_drawn);
        sum += weight * error * error.transpose();
        weights += weight;
        largest = std::max(largest, weight);
    }
    if (!(weights > 50 * largest)) return std::nullopt;  // hardly any sample tells
    return sum / weights;
}

/// The other place from which a small piece of floor looks about the same: the floor's normal mirrored at the line of sight.
/// Source: the twofold ambiguity of planar poses (Schweighofer and Pinz 2006).
std::optional<Eigen::Isometry3d> mirrored_pose(const Eigen::Isometry3d& map_from_camera, const std::vector<FloorSource>& sources) {
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    double count = 0;
    for (const FloorSource& source : sources) {
        for (const FloorSighting& s : source.sightings) middle += Eigen::Vector3d(s.map.x(), s.map.y(), 0), ++count;
    }
    if (count == 0) return std::nullopt;
    middle /= count;
    const Eigen::Vector3d sight = (map_from_camera.translation() - middle).normalized(), normal = Eigen::Vector3d::UnitZ();
    const Eigen::Vector3d other_normal = 2 * sight.dot(normal) * sight - normal;
    // What turns the other normal upright turns the camera along, about the piece of floor that is looked at.
    const Eigen::Quaterniond turn = Eigen::Quaterniond::FromTwoVectors(other_normal, normal);
    Eigen::Isometry3d mirrored = Eigen::Isometry3d::Identity();
    mirrored.linear() = turn * map_from_camera.linear();
    mirrored.translation() = middle + turn * (map_from_camera.translation() - middle);
    if (!(mirrored.translation().z() > 0)) return std::nullopt;
    return mirrored;
}

/// Where the camera is, roughly: by points, or by a corner.
Result<Eigen::Isometry3d> start_of(const CameraModel& model, const std::vector<FloorSource>& sources) {
    std::vector<FloorPoint> points;
    for (const FloorSource& source : sources) {
        for (const FloorSighting& s : source.sightings) {
            if (tells_both_directions(s) && !source.outliers) points.push_back({s.pixel, s.map});
        }
    }
    Error missing{"nothing tells where the camera is: click four points of the floor or a tile, lay out tags, or name a corner"};
    if (!points.empty()) {
        const auto solved = camera_pose_from_floor_points(model, points, 0.5);
        if (solved) return solved->map_from_camera.pose;
        missing = solved.error();
    }
    for (const FloorSource& source : sources) {
        if (source.pose) return source.pose->pose;
    }
    return missing;
}

}  // namespace

FloorSighting clicked_point(const Eigen::Vector2d& pixel, const Eigen::Vector2d& map, double sigma) {
    return {pixel, map, Eigen::Matrix2d::Identity() / (sigma * sigma)};
}

Result<FloorCalibration> calibrate_floor(const CameraModel& model, const IntrinsicsMatrix& intrinsics, const std::vector<FloorSource>& sources,
                                         const std::optional<UncertainPose3>& start) {
    View view{model, start.value_or(UncertainPose3{})};
    if (!start) {
        const auto found = start_of(model, sources);
        if (!found) return found.error();
        view.map_from_camera.pose = *found;
    }
    if (sources.empty()) return Error{"nothing tells where the camera is"};
    auto at = refine(view, sources);
    if (!visible(at)) return Error{"a point of the floor is where the camera cannot see it: check the points and the lens"};
    FloorCalibration result;
    const auto cost_of = [](const std::vector<Linearised>& all) { return sum_of(all, [](const Linearised& l) { return l.cost; }); };
    if (const auto mirrored = mirrored_pose(view.map_from_camera.pose, sources)) {
        View other = view;
        other.map_from_camera.pose = *mirrored;
        auto there = refine(other, sources);
        const bool another = error_between(view.map_from_camera.pose, other.map_from_camera.pose).tail<3>().norm() > 0.02;
        if (visible(there) && another && cost_of(there) < cost_of(at)) {
            std::swap(view, other);
            std::swap(at, there);
        }
        if (visible(there) && another && cost_of(there) < cost_of(at) + rival_margin) result.rival = other.map_from_camera.pose;
    }
    const Matrix6d information = sum_of(at, [](const Linearised& l) { return l.information; });
    if (!fixes_pose(information)) return Error{"these points do not fix the camera's pose: add some that span an area of the floor"};
    const Matrix6d own = information.inverse();
    const double rows = sum_of(at, [](const Linearised& l) { return l.rows; });
    const double freedom = std::max(rows - 6, 1.0);
    const double chi = sum_of(at, [](const Linearised& l) { return l.squares; }) / freedom;
    // Points that disagree by clearly more than their noise are believed: then they are not as good.
    const double inflation = chi > 1 + 3 * std::sqrt(2 / freedom) ? chi : 1;
    result.map_from_camera = {view.map_from_camera.pose, inflation * curved_covariance(view, sources, own).value_or(own)};
    for (std::size_t i = 0; i < at.size(); ++i) {
        result.map_from_camera.covariance += common_errors(sources[i], at[i], own);
    }
    result.by_intrinsics = -own * sum_of(at, [](const Linearised& l) { return l.by_intrinsics; });
    const double weights = sum_of(at, [](const Linearised& l) { return l.weights; });
    if (weights > 0) result.rms = std::sqrt(sum_of(at, [](const Linearised& l) { return l.pixels; }) / weights);
    result.floor_error = floor_error({model, result.map_from_camera, {intrinsics, result.by_intrinsics}});
    for (std::size_t i = 0; i < at.size(); ++i) {
        FloorContribution c{sources[i].name, static_cast<int>(sources[i].sightings.size()), 0, {}, (own * at[i].information).trace() / 6};
        if (at[i].weights > 0) c.rms = std::sqrt(at[i].pixels / at[i].weights);
        if (fixes_pose(at[i].information)) {
            const Matrix6d inverse = at[i].information.inverse();
            const Matrix6d alone = inflation * inverse + common_errors(sources[i], at[i], inverse);
            c.alone = floor_error({model, {view.map_from_camera.pose, alone}});
        }
        result.contributions.push_back(c);
    }
    return result;
}

std::optional<double> floor_sigma(const View& view, const Eigen::Vector2d& pixel) {
    const auto floor = pixel_to_plane(view, pixel, 0);
    if (!floor) return std::nullopt;
    const auto by = plane_point_by_calibration(view, *floor, 0);
    return by ? std::optional(by->norm()) : std::nullopt;
}

double floor_error(const View& view) {
    const auto pixels = spread_pixels(view.model);
    double sum = 0;
    int count = 0;
    for (Eigen::Index i = 0; i < pixels.cols(); ++i) {
        const auto floor = pixel_to_plane(view, pixels.col(i), 0);
        if (!floor || (floor->point - view.position().head<2>()).norm() > 8 * view.position().z()) continue;
        const auto sigma = floor_sigma(view, pixels.col(i));
        if (!sigma) continue;
        sum += *sigma * *sigma;
        ++count;
    }
    return count > 0 ? std::sqrt(sum / count) : 0;
}

}  // namespace roomfix
