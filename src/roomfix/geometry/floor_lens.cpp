#include "roomfix/geometry/floor_lens.hpp"

#include <algorithm>
#include <cmath>

#include "roomfix/base/decompositions.hpp"
#include "roomfix/base/levenberg_marquardt.hpp"
#include "roomfix/geometry/view.hpp"

namespace roomfix {
namespace {

constexpr int all_errors = 6 + most_intrinsics;
using Numbers = Eigen::Matrix<double, all_errors, 1>;
using Information = Eigen::Matrix<double, all_errors, all_errors>;
constexpr double strong = 10;
constexpr int free_numbers = 5;  // of a lens that floor points tell: focal length, centre, and the strongest of the distortion

IntrinsicsMatrix covariance_of(const LensPrior& prior, const CameraModel& model) {
    IntrinsicsMatrix covariance = IntrinsicsMatrix::Zero();
    const double common = prior.focal * prior.focal;
    const double own = 0.5 * prior.aspect * prior.aspect;
    covariance(0, 0) = (common + own) * model.fx * model.fx;
    covariance(1, 1) = (common + own) * model.fy * model.fy;
    covariance(0, 1) = covariance(1, 0) = common * model.fx * model.fy;
    covariance(2, 2) = covariance(3, 3) = std::pow(prior.centre * model.width, 2);
    for (int i = 0; i < distortion_count(model.kind); ++i) {
        const bool tangential = model.kind != Distortion::equidistant && (i == 2 || i == 3);
        const double size = std::abs(model.distortion[static_cast<std::size_t>(i)]);
        const double sigma = tangential ? prior.tangential : std::max(prior.distortion * size, prior.least_radial);
        covariance(4 + i, 4 + i) = sigma * sigma;
    }
    return covariance;
}

struct Fit {
    Information information = Information::Zero();  // px^-2
    Numbers gradient = Numbers::Zero();
    double squares = 0;
};

std::optional<Fit> linearise(const CameraModel& model, const Eigen::Isometry3d& pose, const std::vector<FloorPoint>& points) {
    View view;
    view.model = model;
    view.map_from_camera.pose = pose;
    view.intrinsics_uncertain = true;
    Fit fit;
    for (const FloorPoint& point : points) {
        ViewJacobian jacobian;
        const auto pixel = project_map_point(view, {point.map.x(), point.map.y(), 0}, &jacobian);
        if (!pixel) return std::nullopt;
        Eigen::Matrix<double, 2, all_errors> by;
        by << jacobian.by_pose, jacobian.by_intrinsics;
        const Eigen::Vector2d residual = point.pixel - *pixel;
        fit.information += by.transpose() * by;
        fit.gradient += by.transpose() * residual;
        fit.squares += residual.squaredNorm();
    }
    return fit;
}

}  // namespace

std::optional<FloorLens> lens_from_floor_points(const CameraModel& model, const FloorPointsPose& pose, const std::vector<FloorPoint>& points,
                                                const LensPrior& prior) {
    if (points.size() < enough_floor_points || model.grid) return std::nullopt;
    const double count = 2.0 * static_cast<double>(points.size());
    const int numbers = model.intrinsics_count();
    const IntrinsicsMatrix spread = covariance_of(prior, model);
    IntrinsicsMatrix prior_information = IntrinsicsMatrix::Zero();
    prior_information.topLeftCorner(numbers, numbers) = spread.topLeftCorner(numbers, numbers).inverse();
    for (int i = numbers; i < most_intrinsics; ++i) prior_information(i, i) = 1;

    const auto before = linearise(model, pose.map_from_camera.pose, points);
    if (!before) return std::nullopt;
    const IntrinsicsVector stated = model.intrinsics();
    FloorLens lens{model, pose.map_from_camera};
    Fit fit = *before;
    // The noise of the points is learned along: what the fit leaves, with a little of what it left before as a start.
    constexpr double least_variance = 0.02 * 0.02;  // px^2
    double variance = std::max(before->squares / (count - 6), least_variance);
    const auto cost = [&](const Fit& f, const CameraModel& m) {
        const IntrinsicsVector off = m.intrinsics() - stated;
        return f.squares / variance + off.dot(prior_information * off);
    };
    levenberg_marquardt({.start = 1e-4, .least = 1e-12, .most = 1e10, .rounds = 60}, [&](double damping) {
        Eigen::MatrixXd information = fit.information / variance;
        information.bottomRightCorner<most_intrinsics, most_intrinsics>() += prior_information;
        Eigen::VectorXd gradient = fit.gradient / variance;
        gradient.tail<most_intrinsics>() -= prior_information * (lens.model.intrinsics() - stated);
        const Numbers step = damped_step(information, gradient, damping);
        CameraModel next_model = lens.model;
        next_model.set_intrinsics(lens.model.intrinsics() + step.tail<most_intrinsics>());
        next_model.prepare();
        const Eigen::Isometry3d next_pose = perturbed(lens.map_from_camera.pose, step.head<6>());
        const auto next = linearise(next_model, next_pose, points);
        if (!next || cost(*next, next_model) > cost(fit, lens.model)) return StepResult::worse;
        lens.model = next_model;
        lens.map_from_camera.pose = next_pose;
        fit = *next;
        variance = std::max(fit.squares / (count - 6 - free_numbers), least_variance);
        return step.norm() < 1e-10 ? StepResult::settled : StepResult::better;
    });
    lens.rms = std::sqrt(fit.squares / (count - 6 - free_numbers));
    lens.evidence = count * std::log(std::max(before->squares, 1e-12) / std::max(fit.squares, count * least_variance)) - free_numbers * std::log(count);
    if (!(lens.evidence > strong)) return std::nullopt;

    Information information = fit.information / variance;
    information.bottomRightCorner<most_intrinsics, most_intrinsics>() += prior_information;
    const Information covariance = Eigen::MatrixXd(information).inverse();
    const Matrix6d pose_information = fit.information.topLeftCorner<6, 6>();
    lens.intrinsics.covariance.topLeftCorner(numbers, numbers) = covariance.block(6, 6, numbers, numbers);
    lens.intrinsics.pose_by = -pose_information.ldlt().solve(fit.information.topRightCorner<6, most_intrinsics>());
    lens.intrinsics.pose_by.rightCols(most_intrinsics - numbers).setZero();
    lens.map_from_camera.covariance = variance * pose_information.inverse();
    return lens;
}

}  // namespace roomfix
