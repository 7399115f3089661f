#include "roomfix/ceiling/tag_locator.hpp"

#include <algorithm>
#include <cmath>

#include "roomfix/base/decompositions.hpp"
#include "roomfix/base/levenberg_marquardt.hpp"
#include "roomfix/geometry/floor_points.hpp"
#include "roomfix/geometry/view.hpp"

namespace roomfix {
namespace {

using Vector8d = Eigen::Matrix<double, 8, 1>;
using Matrix8d = Eigen::Matrix<double, 8, 8>;

/// A plane far away looks nearly the same when it tilts the other way about the line of sight.
Eigen::Isometry3d tilted_the_other_way(const Eigen::Isometry3d& camera_from_tag) {
    const Eigen::Matrix3d along_sight = Eigen::Quaterniond::FromTwoVectors(camera_from_tag.translation(), Eigen::Vector3d::UnitZ()).toRotationMatrix();
    const Eigen::Matrix3d mirror = Eigen::Vector3d(1, 1, -1).asDiagonal();
    Eigen::Isometry3d other = camera_from_tag;
    other.linear() = along_sight.transpose() * mirror * along_sight * camera_from_tag.linear() * mirror;
    return other;
}

}  // namespace

/// What tags and height say of the pose at one place.
struct TagLocator::Linearised {
    Matrix6d information = Matrix6d::Zero();
    Vector6d gradient = Vector6d::Zero();
    Eigen::Matrix<double, 6, most_intrinsics> by_intrinsics = Eigen::Matrix<double, 6, most_intrinsics>::Zero();
    double chi_square = 0;
    std::vector<double> of_tag;  // chi-square of each tag
};

struct TagLocator::Fit {
    Eigen::Isometry3d map_from_camera;
    Linearised at;
};

TagLocator::TagLocator(const Site& site, const SiteCamera& camera, const TagLocatorSettings& settings)
    : landmarks_(site.landmarks), model_(camera.model), intrinsics_(camera.intrinsics_covariance), settings_(settings) {
    if (const auto* known = std::get_if<KnownHeight>(&camera.placement)) height_ = *known;
}

const SiteLandmark* TagLocator::landmark_of(const SeenTag& seen) const {
    for (const SiteLandmark& landmark : landmarks_) {
        const auto* tag = std::get_if<Tag>(&landmark.kind);
        if (tag && tag->is(seen.family, seen.number)) return &landmark;
    }
    return nullptr;
}

std::vector<Eigen::Isometry3d> TagLocator::starts(const SeenTag& seen, const SiteLandmark& tag) const {
    // The tag as a little floor, seen from above.
    std::vector<FloorPoint> corners;
    const auto own = own_points(tag.kind);
    for (std::size_t i = 0; i < own.size(); ++i) corners.push_back({seen.corners[i], own[i].head<2>()});
    const auto found = camera_pose_from_floor_points(model_, corners, std::sqrt(seen.covariance.diagonal().mean()));
    if (!found) return {};
    const Eigen::Isometry3d& tag_from_camera = found->map_from_camera.pose;
    const Eigen::Isometry3d other = tilted_the_other_way(tag_from_camera.inverse()).inverse();
    return {tag.map_from_landmark * tag_from_camera, tag.map_from_landmark * other};
}

/// Each tag's errors of place and turn count as noise that its corners share.
std::optional<TagLocator::Linearised> TagLocator::linearise(std::span<const SeenTag> seen, const std::vector<int>& used,
                                                            const Eigen::Isometry3d& map_from_camera) const {
    View view;
    view.model = model_;
    view.map_from_camera.pose = map_from_camera;
    view.intrinsics_uncertain = intrinsics_.diagonal().maxCoeff() > 0;
    Linearised l;
    for (const int index : used) {
        const SeenTag& tag = seen[static_cast<std::size_t>(index)];
        const SiteLandmark& landmark = *landmark_of(tag);
        const auto points = map_points(landmark);
        Vector8d residual;
        Eigen::Matrix<double, 8, 6> by_pose, by_tag;
        Eigen::Matrix<double, 8, most_intrinsics> by_intrinsics = Eigen::Matrix<double, 8, most_intrinsics>::Zero();
        for (int i = 0; i < 4; ++i) {
            const auto k = static_cast<std::size_t>(i);
            ViewJacobian j;
            const auto pixel = project_map_point(view, points[k], &j);
            if (!pixel) return std::nullopt;
            residual.segment<2>(2 * i) = tag.corners[k] - *pixel;
            by_pose.middleRows<2>(2 * i) = j.by_pose;
            by_tag.middleRows<2>(2 * i) << landmark.sigma * j.by_point,
                -landmark.tilt_sigma * j.by_point * skew(points[k] - landmark.map_from_landmark.translation());
            if (view.intrinsics_uncertain) by_intrinsics.middleRows<2>(2 * i) = j.by_intrinsics;
        }
        const Eigen::LLT<Matrix8d> solver(tag.covariance + by_tag * by_tag.transpose());
        const Eigen::Matrix<double, 8, 6> weighted = solver.solve(by_pose);
        l.information += by_pose.transpose() * weighted;
        l.gradient += weighted.transpose() * residual;
        l.by_intrinsics -= weighted.transpose() * by_intrinsics;
        l.of_tag.push_back(residual.dot(solver.solve(residual)));
        l.chi_square += l.of_tag.back();
    }
    if (height_) {
        const double weight = 1 / (height_->sigma * height_->sigma);
        const double off = height_->height - map_from_camera.translation().z();
        l.information(2, 2) += weight;
        l.gradient(2) += weight * off;
        l.chi_square += weight * off * off;
    }
    return l;
}

/// Levenberg-Marquardt from one start.
std::optional<TagLocator::Fit> TagLocator::fit(std::span<const SeenTag> seen, const std::vector<int>& used, Eigen::Isometry3d map_from_camera) const {
    auto at = linearise(seen, used, map_from_camera);
    if (!at) return std::nullopt;
    const bool possible = levenberg_marquardt({.start = 1e-4, .rounds = settings_.most_rounds}, [&](double damping) {
        const Vector6d step = damped_step(at->information, at->gradient, damping);
        if (!step.allFinite()) return StepResult::impossible;
        const Eigen::Isometry3d moved = perturbed(map_from_camera, step);
        const auto next = linearise(seen, used, moved);
        if (!next || !(next->chi_square <= at->chi_square + 1e-9)) return StepResult::worse;
        map_from_camera = moved;
        at = next;
        return step.norm() < 1e-9 ? StepResult::settled : StepResult::better;
    });
    if (!possible) return std::nullopt;
    return Fit{map_from_camera, *at};
}

/// Tags that the place cannot explain are left out, the worst first.
std::optional<TagCameraPlace> TagLocator::settle(std::span<const SeenTag> seen, const std::vector<int>& known, const Eigen::Isometry3d& start) const {
    std::vector<int> used = known;
    while (!used.empty()) {
        const auto fitted = fit(seen, used, start);
        if (!fitted) return std::nullopt;
        const auto& of_tag = fitted->at.of_tag;
        const auto worst = std::max_element(of_tag.begin(), of_tag.end());
        if (*worst > settings_.another_tag) {
            used.erase(used.begin() + (worst - of_tag.begin()));
            continue;
        }
        const Eigen::LLT<Matrix6d> factor(fitted->at.information);
        if (factor.info() != Eigen::Success) return std::nullopt;
        TagCameraPlace place;
        place.map_from_camera.pose = fitted->map_from_camera;
        place.map_from_camera.covariance = factor.solve(Matrix6d::Identity());
        const Eigen::Matrix<double, 6, most_intrinsics> by = factor.solve(fitted->at.by_intrinsics);
        place.map_from_camera.covariance += by * intrinsics_ * by.transpose();
        place.chi_square = fitted->at.chi_square;
        place.tags = used;
        return place;
    }
    return std::nullopt;
}

void TagLocator::locate(std::span<const SeenTag> seen, LocatedByTags& result) const {
    result.places.clear();
    result.reason.clear();
    std::vector<int> known;
    for (std::size_t i = 0; i < seen.size(); ++i) {
        if (landmark_of(seen[i])) known.push_back(static_cast<int>(i));
    }
    for (const int index : known) {
        const SeenTag& tag = seen[static_cast<std::size_t>(index)];
        for (const Eigen::Isometry3d& start : starts(tag, *landmark_of(tag))) {
            const auto place = settle(seen, known, start);
            const auto same = [&](const TagCameraPlace& other) {
                return error_between(other.map_from_camera.pose, place->map_from_camera.pose).cwiseAbs().maxCoeff() < settings_.same_place;
            };
            if (place && std::none_of(result.places.begin(), result.places.end(), same)) result.places.push_back(*place);
        }
    }
    if (result.places.empty()) {
        result.reason = known.empty() ? (seen.empty() ? "no tag in the picture" : "the picture shows tags, but none that the site has")
                                      : "no place of the camera explains a tag: are the site's tags where it says, and as large?";
        return;
    }
    const auto cost = [&](const TagCameraPlace& place) {
        return 0.5 * place.chi_square + settings_.unexplained * static_cast<double>(known.size() - place.tags.size());
    };
    std::stable_sort(result.places.begin(), result.places.end(), [&](const auto& a, const auto& b) { return cost(a) < cost(b); });
    // Where even the best fits worse than the noise allows, the misfits of the others say less, too.
    const TagCameraPlace best = result.places.front();
    const double freedom = std::max(8.0 * static_cast<double>(best.tags.size()) - 6, 1.0);
    const double excess = std::max(1.0, best.chi_square / freedom);
    double sum = 0;
    for (TagCameraPlace& place : result.places) {
        place.weight = std::exp((cost(best) - cost(place)) / excess);
        if (excess > 1 + 3 * std::sqrt(2 / freedom)) place.map_from_camera.covariance *= excess;
    }
    std::erase_if(result.places, [&](const TagCameraPlace& place) { return place.weight < settings_.least_weight; });
    for (const TagCameraPlace& place : result.places) sum += place.weight;
    for (TagCameraPlace& place : result.places) place.weight /= sum;
}

}  // namespace roomfix
