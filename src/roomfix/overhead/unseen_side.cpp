#include "roomfix/overhead/unseen_side.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "roomfix/base/decompositions.hpp"
#include "roomfix/base/fixed_list.hpp"
#include "roomfix/base/median.hpp"
#include "roomfix/overhead/wall_cover.hpp"

namespace roomfix {
namespace {

constexpr std::size_t most_fits = 3;  // the whole outline, and either side hidden
constexpr double far_outside = 1e5;   // px

/// How the foreground lies to an outline from left to right, px.
struct Extent {
    double begin = 0, end = 0;     // columns where the foreground does
    double before = 0, after = 0;  // by which its ends lie to the right of the outline's
    double width = 0;              // of the outline

    double narrower() const { return before - after; }
};

/// Nothing where too few rows tell it: cut off by the picture's border, or beside another robot.
std::optional<Extent> extent_of(const BitMask& mask, const Silhouette& silhouette, const std::vector<Silhouette>& others) {
    constexpr int step = 2;  // rows
    constexpr std::size_t least_rows = 5;
    constexpr int least_width = 4;  // px
    constexpr int border = 3;       // px
    constexpr double beside = 4;    // px
    thread_local std::vector<double> begins, ends, before, after, width;
    for (auto* values : {&begins, &ends, &before, &after, &width}) values->clear();
    std::size_t rows = 0;
    for_polygon_rows(silhouette.polygon(), mask.width(), mask.height(), step, [&](int y, int begin, int end) {
        if (end - begin < least_width) return;
        ++rows;
        const int reach = (end - begin) / 2;
        int from = std::clamp(begin - reach, 0, mask.width());
        int to = std::clamp(end + reach, 0, mask.width());
        while (from < to && !mask.at(from, y)) ++from;
        while (to > from && !mask.at(to - 1, y)) --to;
        const bool cut_off = from >= to || from < border || to > mask.width() - border;
        if (cut_off || inside_any(others, Eigen::Vector2d(from, y), beside) || inside_any(others, Eigen::Vector2d(to, y), beside)) return;
        begins.push_back(from);
        ends.push_back(to);
        before.push_back(from - begin);
        after.push_back(to - end);
        width.push_back(end - begin);
    });
    if (width.size() < least_rows || 2 * width.size() < rows) return std::nullopt;
    return Extent{median(begins), median(ends), median(before), median(after), median(width)};
}

/// All of the picture between two columns.
Silhouette columns(double from, double to) {
    Silhouette cover;
    cover.count = 4;
    cover.corners[0] = {from, -far_outside};
    cover.corners[1] = {to, -far_outside};
    cover.corners[2] = {to, far_outside};
    cover.corners[3] = {from, far_outside};
    return cover;
}

/// The pose whose outline lies so many px farther to the right.
std::optional<Pose2> moved_aside(const View& view, const ShapePoints& shape, const Pose2& pose, double pixels) {
    ViewJacobian jacobian;
    if (!project_map_point(view, {pose.x, pose.y, 0.5 * shape.height}, &jacobian)) return std::nullopt;
    const Eigen::Matrix2d by_place = jacobian.by_point.leftCols<2>();
    if (std::abs(by_place.determinant()) < 1e-9) return std::nullopt;
    const Eigen::Vector2d move = by_place.inverse() * Eigen::Vector2d(pixels, 0);
    if (move.norm() > 2 * shape.radius) return std::nullopt;
    return Pose2{pose.x + move.x(), pose.y + move.y(), pose.yaw};
}

/// Nats by which a fit stands too far from where the robot is expected, or is turned otherwise.
double far_from(const OutlineFit& fit, const PoseObservation* expected, const ShapePoints& shape) {
    if (!expected) return 0;
    if (shape.round() || !expected->yaw_known) return 0.5 * squared_distance(fit, expected->pose, expected->covariance);
    const Eigen::Vector3d off = pose_difference(expected->pose, fit.pose, shape);
    return 0.5 * off.dot((expected->covariance + fit.covariance).inverse() * off);
}

}  // namespace

OutlineFit weigh_unseen_sides(const FrameEvidence& evidence, const View& view, std::span<const ShapePoints> parts, const OutlineFit& fit,
                              const std::vector<Silhouette>& others, const PoseObservation* expected, const OutlineFitSettings& fitting,
                              const UnseenSideSettings& settings) {
    const ShapePoints& shape = parts.front();
    if (!fit.determined) return fit;
    if (std::min(fit.left_shown, fit.right_shown) >= settings.side_shown && far_from(fit, expected, shape) < settings.surprising) return fit;
    if (evidence.walls && !in_plain_view(view, *evidence.walls, {fit.pose.x, fit.pose.y}, shape.radius)) return fit;  // it is known what hides it
    // As it is expected: a fit that was led astray may have turned the robot to make it narrower.
    const Pose2 about = expected ? expected->pose : fit.pose;
    const Silhouette outline = project_silhouette(view, shape, about);
    if (!outline.valid()) return fit;
    const auto extent = extent_of(*evidence.mask, outline, others);
    if (!extent || extent->narrower() < settings.narrower || extent->narrower() > (1 - settings.least_seen) * extent->width) return fit;
    FixedList<OutlineFit, most_fits> fits;
    FixedList<double, most_fits> nats;
    const auto add = [&](const OutlineFit& one, double prior) {
        fits.push_back(one);
        nats.push_back(one.edges - far_from(one, expected, shape) + std::log(prior));
    };
    add(fit, 1);
    thread_local std::vector<Silhouette> hiding;
    for (const bool left : {true, false}) {
        const auto start = moved_aside(view, shape, about, left ? extent->after : extent->before);
        if (!start) continue;
        hiding.assign(others.begin(), others.end());
        hiding.push_back(left ? columns(-far_outside, extent->begin) : columns(extent->end, far_outside));
        const OutlineFit tried = fit_outline(evidence, view, parts, *start, hiding, fitting);
        if (tried.determined && tried.supported >= settings.least_shown * tried.visible) add(tried, settings.hidden);
    }
    const auto best = static_cast<std::size_t>(std::max_element(nats.begin(), nats.end()) - nats.begin());
    OutlineFit weighed = fits[best];
    double all = 0;
    Eigen::Matrix3d apart = Eigen::Matrix3d::Zero();
    for (std::size_t i = 0; i < fits.size(); ++i) {
        const double weight = std::exp(nats[i] - nats[best]);
        const Eigen::Vector3d off = pose_difference(weighed.pose, fits[i].pose, shape);
        all += weight;
        apart += weight * off * off.transpose();
    }
    weighed.covariance += apart / all;
    weighed.pixel_covariance += apart / all;
    return weighed;
}

}  // namespace roomfix
