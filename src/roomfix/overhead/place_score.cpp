#include "roomfix/overhead/place_score.hpp"

#include <algorithm>
#include <cmath>

#include "roomfix/base/beta_distribution.hpp"

namespace roomfix {
namespace {

constexpr double rows_enough = 40;  // of a body of one part: more rows say the same

/// Independent samples, and how many of them show something else.
struct SampleCount {
    double n = 0;
    double k = 0;
};

SampleCount samples_of(const Evidence::Sums& sums, double pixels_per_sample) {
    const double n = static_cast<double>(sums.other + sums.plain) / pixels_per_sample;
    return {n, std::clamp(static_cast<double>(sums.other) / pixels_per_sample, 0.0, n)};
}

/// Log probability of one order of k of n, the part of them being of a Beta distribution.
double log_evidence(const SampleCount& s, double filled, double open) { return log_beta_evidence(s.k, s.n, filled, open); }

/// log(exp(a) + exp(b))
double log_of_sum(double a, double b) { return std::max(a, b) + std::log1p(std::exp(-std::abs(a - b))); }

Evidence::Sums sum_over(const Evidence& evidence, const BodyMask& mask, int step) {
    Evidence::Sums sums;
    for (const Span& span : mask.spans) {
        const Evidence::Sums run = evidence.run(span.y, span.begin, span.end);
        sums.other += static_cast<float>(step) * run.other;
        sums.plain += static_cast<float>(step) * run.plain;
    }
    return sums;
}

/// What differs around the body, and a little of the whole picture's share.
double clutter_around(const Evidence& evidence, const BodyMask& mask, const Evidence::Sums& inside, const PlaceScoreSettings& settings) {
    const int across = static_cast<int>(settings.surroundings * (mask.right - mask.left)) + 1;
    const int down = static_cast<int>(settings.surroundings * (mask.bottom - mask.top)) + 1;
    const Evidence::Sums box = evidence.box(std::max(mask.left - across, 0), std::max(mask.top - down, 0), std::min(mask.right + across, evidence.width),
                                            std::min(mask.bottom + down, evidence.height));
    const double other = std::max(static_cast<double>(box.other - inside.other), 0.0);
    const double plain = std::max(static_cast<double>(box.plain - inside.plain), 0.0);
    const double usual = std::max(evidence.clutter, settings.least_clutter);
    const double weight = settings.usual_weight * mask.area;
    return std::clamp((other + weight * usual) / (other + plain + weight), settings.least_clutter, 0.95);
}

}  // namespace

WallCover hidden_from(const SeenBy& camera, const Body& body, const Eigen::Vector2d& place) {
    return camera.walls ? wall_cover(*camera.view, *camera.walls, place, body.radius, body.height, camera.evidence->scale) : WallCover();
}

PlaceScore score_place(const SeenBy& camera, const Body& body, const Pose2& pose, const PlaceScoreSettings& settings, PlaceMemory& memory, bool coarse,
                       double most_samples, const NearBody* near) {
    PlaceScore score;
    const View& view = *camera.view;
    const Evidence& evidence = *camera.evidence;
    const WallCover hidden = hidden_from(camera, body, {pose.x, pose.y});
    if (hidden.whole) return score;
    BodyMask& mask = memory.mask;
    int step = 1;
    if (body.parts.size() == 1) {
        const auto top = project_map_point(view, {pose.x, pose.y, body.height});
        const auto foot = project_map_point(view, {pose.x, pose.y, 0});
        if (!top || !foot) return score;
        step = std::max(1, static_cast<int>(std::abs(foot->y() - top->y()) / evidence.scale / rows_enough));
    }
    const bool nearby = near && near->core.reach(pose) && near->parts.reach(pose);
    const auto cover_with = [&](const std::vector<ConvexPart>& parts, const NearOutlines* outlines) {
        if (outlines) {
            outlines->cover(pose, evidence.width, evidence.height, step, mask);
        } else {
            cover(view, parts, pose, evidence.width, evidence.height, evidence.scale, step, mask);
        }
        take_away(hidden, mask);
    };
    cover_with(body.core, nearby ? &near->core : nullptr);
    if (!mask.valid) return score;
    const Evidence::Sums core = sum_over(evidence, mask, step);
    cover_with(body.parts, nearby ? &near->parts : nullptr);
    if (!mask.valid || mask.area < settings.least_whole * mask.whole || mask.area < 4) return score;
    score.in_picture = true;
    const Evidence::Sums inside = sum_over(evidence, mask, step);
    const double pixels_per_sample = std::max(settings.pixels_per_sample, mask.whole / most_samples);
    const SampleCount all = samples_of(inside, pixels_per_sample);
    const SampleCount middle = samples_of(core, pixels_per_sample);
    const double rim_n = std::max(all.n - middle.n, 0.0);
    const SampleCount rim{rim_n, std::clamp(all.k - middle.k, 0.0, rim_n)};
    score.samples = all.n;
    score.filled = all.n > 0 ? all.k / all.n : 0;
    score.around = clutter_around(evidence, mask, inside, settings);
    double clutter = score.around;
    double body_here = log_evidence(middle, settings.core_filled, settings.core_open) + log_evidence(rim, settings.rim_filled, settings.rim_open);
    if (body.has_edges && settings.floor_coloured > 0) {
        const double anything = log_evidence(all, 1, 1);
        body_here = log_of_sum(std::log(1 - settings.floor_coloured) + body_here, std::log(settings.floor_coloured) + anything);
        score.body_like = std::min(body_here - anything, 0.0);
        clutter = std::min(clutter, std::max(score.filled, settings.least_filled));  // a picture cleaner than usual shows no body
    }
    const double nothing_here = all.k * std::log(clutter) + (all.n - all.k) * std::log(1 - clutter);
    double ratio = body_here - nothing_here;
    if (!coarse && body.placed_by_look() && evidence.with_colours) {
        const LookScore look = score_look(view, evidence, body.learned->look, pose, settings.look.usual_clutter, settings.look, memory.spots);
        if (look.seen >= settings.look.least_spots && hidden.none()) ratio = look.per_spot * mask.whole / pixels_per_sample;
    }
    // It may be hidden altogether.
    score.log_ratio = ratio > 20 ? ratio + std::log(1 - settings.hidden) : std::log(settings.hidden + (1 - settings.hidden) * std::exp(ratio));
    return score;
}

}  // namespace roomfix
