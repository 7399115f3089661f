#include "roomfix/overhead/place_search.hpp"

#include <algorithm>
#include <cmath>

#include "roomfix/overhead/keep_apart.hpp"

namespace roomfix {
namespace {

constexpr double same_place = 0.05;  // of the body's radius, and in radians
constexpr double near_place = 0.2;   // likewise: the same up to a few edges

}  // namespace

PlaceSearch::Result PlaceSearch::find(const FrameEvidence& evidence, const ForegroundMasks& masks, const View& view, const ShapePoints& shape, const Blob& blob,
                                      const Pose2& guess, const OutlineFitSettings& fit_settings, const PlaceSearchSettings& settings) {
    const Component& box = blob.component;
    border_.compute(*masks.foreground, *masks.shadow, evidence.background->mean(), box.left, box.top, box.right, box.bottom);
    border_distance_.compute(border_, evidence.frame.width, evidence.frame.height, box.left, box.top, box.right, box.bottom, 12);
    search_outline(border_distance_, view, shape, floor_under(view, shape, blob), static_cast<std::size_t>(settings.most_glances), starts_);
    starts_.push_back({guess, 0});
    glance(evidence, view, shape, fit_settings, settings);

    OutlineFitSettings close = fit_settings;
    close.first_reach = 6;
    close.first_scale = 2;
    Result best;
    Rival first;
    rivals_.clear();
    for (const OutlineStart& start : glances_) {
        const OutlineFit fit = fit_outline(evidence, view, shape, start.pose, {}, close);
        if (!fit.determined) continue;
        const CoarsePose coarse = coarse_agreement(masks, view, shape, fit.pose, blob);
        const double quality = fit.score - settings.missing_cost * coarse.missing_part() - settings.unexplained_cost * border_.unexplained(fit.silhouette);
        rivals_.push_back({fit.pose, fit.covariance, quality});
        if (rivals_.size() > 1 && quality <= first.quality) continue;
        first = rivals_.back();
        best = {fit, coarse};
    }
    if (rivals_.empty()) return best;
    best.fit.pose = mean_near(first, shape, settings.doubt);
    best.fit.silhouette = project_silhouette(view, shape, best.fit.pose);
    first.pose = best.fit.pose;
    best.fit.covariance = covariance_around(first, shape, settings.doubt);
    return best;
}

/// Fits in a hurry at all starts, and keeps the best of the different places that this leads to.
void PlaceSearch::glance(const FrameEvidence& evidence, const View& view, const ShapePoints& shape, const OutlineFitSettings& fit_settings,
                         const PlaceSearchSettings& settings) {
    OutlineFitSettings hurried = fit_settings;
    hurried.samples = 40;
    hurried.coarse_rounds = 1;
    hurried.rounds = 3;
    hurried.first_reach = 8;
    glances_.clear();
    for (const OutlineStart& start : starts_) {
        const OutlineFit seen = fit_outline(evidence, view, shape, start.pose, {}, hurried);
        if (!seen.determined) continue;
        glances_.push_back({seen.pose, seen.score - settings.unexplained_cost * border_.unexplained(seen.silhouette)});
    }
    std::sort(glances_.begin(), glances_.end(), [](const OutlineStart& a, const OutlineStart& b) { return a.support > b.support; });
    keep_apart(glances_, static_cast<std::size_t>(settings.most_fits), [&](const OutlineStart& a, const OutlineStart& b) {
        const Eigen::Vector3d off = pose_difference(a.pose, b.pose, shape);
        return off.head<2>().norm() < same_place * shape.radius && std::abs(off.z()) < same_place;
    });
}

/// Mean of the places so near to the best one that they are the same up to a few edges, each weighted by how likely it is.
Pose2 PlaceSearch::mean_near(const Rival& best, const ShapePoints& shape, double doubt) const {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double weights = 0;
    for (const Rival& rival : rivals_) {
        const Eigen::Vector3d off = pose_difference(best.pose, rival.pose, shape);
        if (off.head<2>().norm() > near_place * shape.radius || std::abs(off.z()) > near_place) continue;
        const double weight = std::exp((rival.quality - best.quality) / doubt);
        sum += weight * off;
        weights += weight;
    }
    const Eigen::Vector3d mean = sum / weights;
    return {best.pose.x + mean.x(), best.pose.y + mean.y(), wrap_angle(best.pose.yaw + mean.z())};
}

/// Covariance about the best place of the mixture of all places.
Eigen::Matrix3d PlaceSearch::covariance_around(const Rival& best, const ShapePoints& shape, double doubt) const {
    Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
    double weights = 0;
    for (const Rival& rival : rivals_) {
        const double weight = std::exp((rival.quality - best.quality) / doubt);
        const Eigen::Vector3d off = pose_difference(best.pose, rival.pose, shape);
        sum += weight * (rival.covariance + off * off.transpose());
        weights += weight;
    }
    return sum / weights;
}

}  // namespace roomfix
