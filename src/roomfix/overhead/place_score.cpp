#include "roomfix/overhead/place_score.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "roomfix/base/beta_distribution.hpp"

namespace roomfix {
namespace {

constexpr double rows_enough = 32;  // of the lowest of a body's parts: more say the same
constexpr double coarse_rows_enough = 20;

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
    std::uint64_t sums = 0;
    for (const Span& span : mask.spans) sums += evidence.packed_run(span.y, span.begin, span.end);
    return Evidence::unpacked(sums * static_cast<std::uint64_t>(step));
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

/// Of the pixels that a body covers: those of its core, and the others.
struct InsideSamples {
    SampleCount core, rim;
};

InsideSamples inside_samples(const Evidence::Sums& core, const Evidence::Sums& all, double pixels_per_sample) {
    const SampleCount whole = samples_of(all, pixels_per_sample);
    const SampleCount middle = samples_of(core, pixels_per_sample);
    const double rim = std::max(whole.n - middle.n, 0.0);
    return {middle, {rim, std::clamp(whole.k - middle.k, 0.0, rim)}};
}

constexpr int sectors = 8;

/// Octant of a direction.
std::size_t sector_of(double x, double y) { return (x < 0 ? 4u : 0u) + (y < 0 ? 2u : 0u) + (std::abs(x) < std::abs(y) ? 1u : 0u); }

/// Adds what lies in a part of a row to the sectors around a middle that it passes through.
void add_run(const Evidence& evidence, const Span& part, const Eigen::Vector2d& middle, std::array<Evidence::Sums, sectors>& sums) {
    const double down = part.y - middle.y();
    for (int begin = part.begin; begin < part.end;) {
        const std::size_t sector = sector_of(begin - middle.x(), down);
        int end = part.end;
        for (const double border : {-std::abs(down), 0.0, std::abs(down)}) {
            const double x = std::ceil(middle.x() + border);
            if (x > begin && x < end) end = static_cast<int>(x);
        }
        const Evidence::Sums run = evidence.run(part.y, begin, end);
        sums[sector].other += run.other;
        sums[sector].plain += run.plain;
        begin = end;
    }
}

/// What lies in a ring around a convex outline (px of the small picture), but for what walls hide, by its direction from the outline's middle.
std::array<Evidence::Sums, sectors> sums_around(const Evidence& evidence, const std::vector<Eigen::Vector2d>& outline, double reach, const WallCover& hidden,
                                                PlaceMemory& memory) {
    std::array<Evidence::Sums, sectors> sums{};
    Eigen::Vector2d middle = Eigen::Vector2d::Zero();
    for (const Eigen::Vector2d& p : outline) middle += p / static_cast<double>(outline.size());
    memory.rows.assign(static_cast<std::size_t>(evidence.height), {0, evidence.width, evidence.width});
    for_polygon_rows(outline, evidence.width, evidence.height, 1, [&](int y, int begin, int end) {
        memory.rows[static_cast<std::size_t>(y)] = {y, begin, end};
    });
    memory.outline = outline;
    for (Eigen::Vector2d& p : memory.outline) p = middle + reach * (p - middle);
    memory.mask.begin(evidence.width, evidence.height, 1);
    memory.mask.add(memory.outline);
    memory.mask.finish();
    take_away(hidden, memory.mask);
    for (const Span& span : memory.mask.spans) {
        const Span& inside = memory.rows[static_cast<std::size_t>(span.y)];
        add_run(evidence, {span.y, span.begin, std::clamp(inside.begin, span.begin, span.end)}, middle, sums);
        add_run(evidence, {span.y, std::clamp(inside.end, span.begin, span.end), span.end}, middle, sums);
    }
    return sums;
}

}  // namespace

WallCover hidden_from(const SeenBy& camera, const Body& body, const Eigen::Vector2d& place) {
    return camera.walls ? wall_cover(*camera.view, *camera.walls, place, body.radius, body.height, camera.evidence->scale) : WallCover();
}

double covered_part(std::span<const SeenBy> cameras, const Body& body, const Pose2& pose, const Body& other, const Pose2& at_other, PlaceMemory& memory) {
    double common = 0, all = 0;
    for (const SeenBy& camera : cameras) {
        const Evidence& evidence = *camera.evidence;
        cover(*camera.view, body.parts, pose, evidence.width, evidence.height, evidence.scale, 1, memory.mask);
        if (!memory.mask.valid) continue;
        all += memory.mask.area;
        cover(*camera.view, other.parts, at_other, evidence.width, evidence.height, evidence.scale, 1, memory.other);
        if (memory.other.valid) common += common_area(memory.mask, memory.other);
    }
    return all > 0 ? common / all : 0;
}

PlaceScore score_place(const SeenBy& camera, const Body& body, const Pose2& pose, const PlaceScoreSettings& settings, PlaceMemory& memory, bool coarse,
                       double most_samples, const NearBody* near) {
    PlaceScore score;
    const View& view = *camera.view;
    const Evidence& evidence = *camera.evidence;
    const bool nearby = near && near->core.reach(pose) && near->parts.reach(pose);
    const WallCover hidden = nearby && near->unhidden ? WallCover() : hidden_from(camera, body, {pose.x, pose.y});
    if (hidden.whole) return score;
    BodyMask& mask = memory.mask;
    const std::optional<double> rows = nearby ? near->rows : upright_rows(view, body, pose, evidence.scale);
    if (!rows) return score;
    const int step = std::max(1, static_cast<int>(*rows * body.least_part / (coarse ? coarse_rows_enough : rows_enough)));
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
    const auto [middle, rim] = inside_samples(core, inside, pixels_per_sample);
    score.samples = all.n;
    score.silent = std::clamp(1 - all.n * pixels_per_sample / mask.whole, 0.0, 1.0);
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

double score_shape(const SeenBy& camera, const Body& body, const Pose2& pose, const PlaceScoreSettings& settings, PlaceMemory& memory) {
    const Evidence& evidence = *camera.evidence;
    const WallCover hidden = hidden_from(camera, body, {pose.x, pose.y});
    if (hidden.whole) return 0;
    std::vector<Eigen::Vector2d> outline = outline_of(*camera.view, body, pose);
    if (outline.size() < 3) return 0;
    for (Eigen::Vector2d& p : outline) p = (p - Eigen::Vector2d::Constant(0.5 * (evidence.scale - 1))) / evidence.scale;
    BodyMask& mask = memory.mask;
    cover(*camera.view, body.core, pose, evidence.width, evidence.height, evidence.scale, 1, mask);
    take_away(hidden, mask);
    if (!mask.valid) return 0;
    const Evidence::Sums core = sum_over(evidence, mask, 1);
    cover(*camera.view, body.parts, pose, evidence.width, evidence.height, evidence.scale, 1, mask);
    take_away(hidden, mask);
    if (!mask.valid || mask.area < settings.least_whole * mask.whole || mask.area < 4) return 0;
    const InsideSamples inside = inside_samples(core, sum_over(evidence, mask, 1), settings.pixels_per_sample);
    double nats = log_evidence(inside.core, settings.core_filled, settings.core_open) - log_evidence(inside.core, 1, 1) +
                  log_evidence(inside.rim, settings.rim_filled, settings.rim_open) - log_evidence(inside.rim, 1, 1);
    const double differs = std::clamp(evidence.clutter, settings.beside_differs, 0.5);
    for (const Evidence::Sums& sum : sums_around(evidence, outline, settings.ring, hidden, memory)) {
        const SampleCount s = samples_of(sum, settings.pixels_per_sample);
        const double floor = log_evidence(s, settings.beside_samples * differs, settings.beside_samples * (1 - differs));
        const double anything = log_evidence(s, 1, 1);
        const auto mixed = [&](double part) { return log_of_sum(std::log(1 - part) + floor, std::log(part) + anything); };
        nats += mixed(settings.something_beside) - mixed(settings.goes_on);
    }
    return nats;
}

}  // namespace roomfix
