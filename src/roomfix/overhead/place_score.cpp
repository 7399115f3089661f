#include "roomfix/overhead/place_score.hpp"

#include <algorithm>
#include <cmath>

namespace roomfix {
namespace {

/// log of B(a, b).
double log_beta(double a, double b) { return std::lgamma(a) + std::lgamma(b) - std::lgamma(a + b); }

constexpr double rows_enough = 40;  // of a body of one part: more rows say the same

}  // namespace

PlaceScore score_place(const View& view, const Evidence& evidence, const Body& body, const Pose2& pose, const PlaceScoreSettings& settings, BodyMask& mask) {
    PlaceScore score;
    int step = 1;
    if (body.parts.size() == 1) {
        const auto top = project_map_point(view, {pose.x, pose.y, body.height});
        const auto foot = project_map_point(view, {pose.x, pose.y, 0});
        if (!top || !foot) return score;
        step = std::max(1, static_cast<int>(std::abs(foot->y() - top->y()) / evidence.scale / rows_enough));
    }
    cover(view, body, pose, evidence.width, evidence.height, evidence.scale, step, mask);
    if (!mask.valid || mask.area < settings.least_whole * mask.whole || mask.area < 4) return score;
    score.in_picture = true;
    double other = 0;
    for (const Span& span : mask.spans) other += step * static_cast<double>(evidence.run(span.y, span.begin, span.end));
    // Clutter: what differs around the body, and a little of the whole picture's share.
    const int across = static_cast<int>(settings.surroundings * (mask.right - mask.left)) + 1;
    const int down = static_cast<int>(settings.surroundings * (mask.bottom - mask.top)) + 1;
    const int left = std::max(mask.left - across, 0);
    const int top = std::max(mask.top - down, 0);
    const int right = std::min(mask.right + across, evidence.width);
    const int bottom = std::min(mask.bottom + down, evidence.height);
    const double outside = std::max((right - left) * static_cast<double>(bottom - top) - mask.area, 0.0);
    const double other_outside = std::clamp(evidence.box(left, top, right, bottom) - other, 0.0, outside);
    const double usual = std::max(evidence.mean, settings.least_clutter);
    const double weight = 0.25 * mask.area;
    const double clutter = std::clamp((other_outside + weight * usual) / (outside + weight), settings.least_clutter, 0.95);

    const double n = mask.area / settings.pixels_per_sample;
    const double k = std::clamp(other / settings.pixels_per_sample, 0.0, n);
    score.samples = n;
    score.filled = k / n;
    score.around = clutter;
    const double body_here = log_beta(settings.filled + k, settings.open + n - k) - log_beta(settings.filled, settings.open);
    const double nothing_here = k * std::log(clutter) + (n - k) * std::log(1 - clutter);
    const double ratio = body_here - nothing_here;
    // It may be hidden altogether.
    score.log_ratio = ratio > 20 ? ratio + std::log(1 - settings.hidden) : std::log(settings.hidden + (1 - settings.hidden) * std::exp(ratio));
    return score;
}

}  // namespace roomfix
