#include "roomfix/overhead/body_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "roomfix/base/decompositions.hpp"
#include "roomfix/overhead/keep_apart.hpp"

namespace roomfix {
namespace {

constexpr int coarse_halvings = 4;  // of a climb by coarse scores
constexpr int turns_of_look = 16;   // in which it is compared all over the floor

/// Halton's sequence, van der Corput's with a prime base.
double halton(int index, int base) {
    double result = 0;
    double part = 1;
    for (int i = index; i > 0; i /= base) {
        part /= base;
        result += part * (i % base);
    }
    return result;
}

/// Two independent normal numbers from two even ones (Box and Muller).
Eigen::Vector2d normal_pair(double u, double v) {
    const double r = std::sqrt(-2 * std::log(std::max(u, 1e-12)));
    return {r * std::cos(2 * std::numbers::pi * v), r * std::sin(2 * std::numbers::pi * v)};
}

bool better(const BodyCandidate& a, const BodyCandidate& b) { return a.total() > b.total(); }

/// What a body's description leaves out is the same in the next frame.
void note_lasting(BodyPlace& place, const Body& body, double part) {
    const Eigen::Matrix3d own = place.covariance - place.by_calibration * place.by_calibration.transpose();
    const Eigen::LLT<Eigen::Matrix3d> root(part * own);
    if (root.info() != Eigen::Success) return;
    place.lasting.root = root.matrixL();
    if (body.round()) place.lasting.root.row(2).setZero();
    if (std::count(place.seen.begin(), place.seen.end(), 1) > 1) return;
    place.lasting.only_camera = static_cast<int>(std::find(place.seen.begin(), place.seen.end(), 1) - place.seen.begin());
}

/// A step to each side along x and y (m) and to each side of the turn (rad).
std::array<Eigen::Vector3d, 6> steps_around(double step, double turn) {
    return {Eigen::Vector3d(step, 0, 0),  Eigen::Vector3d(-step, 0, 0), Eigen::Vector3d(0, step, 0),
            Eigen::Vector3d(0, -step, 0), Eigen::Vector3d(0, 0, turn),  Eigen::Vector3d(0, 0, -turn)};
}

Pose2 moved(const Pose2& pose, const Eigen::Vector3d& by) { return {pose.x + by.x(), pose.y + by.y(), wrap_angle(pose.yaw + by.z())}; }

}  // namespace

/// Of a body in the picture of one of the cameras.
static double samples_at_most(std::span<const SeenBy> cameras, const BodySearchSettings& settings) {
    return cameras.size() > 1 ? settings.samples_together : 1e9;
}

/// `near`: of each camera; null: the pose is like no other.
static double sum_of_scores(std::span<const SeenBy> cameras, const Body& body, const Pose2& pose, const BodySearchSettings& settings, PlaceMemory& memory,
                            bool coarse, const NearBody* near) {
    double sum = 0;
    const double most_samples = samples_at_most(cameras, settings);
    for (std::size_t c = 0; c < cameras.size(); ++c) {
        const NearBody* own = near ? near + c : nullptr;
        sum += score_place(cameras[c], body, pose, settings.score, memory, coarse, most_samples, own).log_ratio;
    }
    return sum;
}

BodySearch::BodySearch(const BodySearchSettings& settings) : settings_(settings) {
    for (int i = 1; i <= settings.spread_samples * settings.spread_rounds; ++i) {
        const Eigen::Vector2d first = normal_pair(halton(i, 2), halton(i, 3));
        units_.emplace_back(first.x(), first.y(), normal_pair(halton(i, 5), halton(i, 7)).x());
    }
}

double BodySearch::score(std::span<const SeenBy> cameras, const Body& body, const Pose2& pose, bool coarse) {
    return sum_of_scores(cameras, body, pose, settings_, memory_, coarse, nullptr);
}

double BodySearch::absence(std::span<const SeenBy> cameras, const Body& body, const Pose2& pose) {
    double sum = 0;
    const double most_samples = samples_at_most(cameras, settings_);
    for (const SeenBy& camera : cameras) {
        const PlaceScore here = score_place(camera, body, pose, settings_.score, memory_, false, most_samples);
        if (here.in_picture) sum += std::max(here.log_ratio, std::log(std::max(here.silent, settings_.score.hidden)));
    }
    return std::min(sum, 0.0);
}

/// Along the ray of one camera alone a body has nearly one shape: there its score tells where it stands. So does a look.
static bool placed_by_shape(std::span<const SeenBy> cameras, const Body& body) { return cameras.size() > 1 && !body.placed_by_look(); }

double BodySearch::odds(std::span<const SeenBy> cameras, const Body& body, const Pose2& pose) {
    return placed_by_shape(cameras, body) ? odds_of_shape(cameras, body, pose) : score(cameras, body, pose);
}

double BodySearch::odds_of_shape(std::span<const SeenBy> cameras, const Body& body, const Pose2& pose) {
    const double most_samples = samples_at_most(cameras, settings_);
    double sum = 0;
    for (const SeenBy& camera : cameras) {
        const double against_nothing = score_place(camera, body, pose, settings_.score, memory_, false, most_samples).log_ratio;
        if (against_nothing <= 0) {
            sum += against_nothing;
            continue;
        }
        const double shape = score_shape(camera, body, pose, settings_.score, memory_);
        const double against_thing = settings_.odds_of_clutter + shape;
        const double less = std::min(against_nothing, against_thing);
        const double odds = less - std::log1p(std::exp(less - std::max(against_nothing, against_thing)));
        // What stands there may as well hide the body.
        sum += std::log(settings_.score.hidden + (1 - settings_.score.hidden) * std::exp(std::min(odds, 500.0)));
    }
    return sum;
}

void BodySearch::weigh(std::span<const SeenBy> cameras, const Body& body, std::vector<BodyCandidate>& candidates) {
    const bool by_shape = placed_by_shape(cameras, body);
    for (BodyCandidate& candidate : candidates) candidate.odds = by_shape ? odds_of_shape(cameras, body, candidate.pose) : candidate.score;
    if (!by_shape) return;
    // Of candidates that are in each other's way the one that explains more of the pictures is the likelier one, whatever lies around it.
    std::sort(candidates.begin(), candidates.end(), [](const BodyCandidate& a, const BodyCandidate& b) { return a.score > b.score; });
    for (std::size_t c = 1; c < candidates.size(); ++c) {
        for (std::size_t better = 0; better < c; ++better) {
            const BodyCandidate& a = candidates[better];
            BodyCandidate& b = candidates[c];
            if (std::hypot(a.pose.x - b.pose.x, a.pose.y - b.pose.y) > 2 * body.inner_radius) continue;
            b.odds = std::min(b.odds, a.odds - trust_in(a.score) * (a.score - b.score));
        }
    }
}

/// From now on score_near() is fast around this pose.
void BodySearch::prepare_near(std::span<const SeenBy> cameras, const Body& body, const Pose2& pose) {
    near_.resize(std::max(near_.size(), cameras.size()));
    for (std::size_t c = 0; c < cameras.size(); ++c) near_[c].prepare(*cameras[c].view, cameras[c].walls, body, pose, cameras[c].evidence->scale);
}

/// As score().
double BodySearch::score_near(std::span<const SeenBy> cameras, const Body& body, const Pose2& pose, bool coarse) {
    return sum_of_scores(cameras, body, pose, settings_, memory_, coarse, near_.data());
}

std::optional<double> BodySearch::agreement(std::span<const SeenBy> cameras, const Body& body, const Pose2& pose, std::size_t step) {
    double sum = 0;
    int spots = 0;
    for (const SeenBy& camera : cameras) {
        if (!body.has_look() || !camera.evidence->with_colours) continue;
        const LookSettings& settings = settings_.score.look;
        const LookScore seen = score_look(*camera.view, *camera.evidence, body.learned->look, pose, settings.usual_clutter, settings, memory_.spots, step);
        if (seen.seen < settings.least_spots) continue;
        sum += seen.per_spot * seen.spots;
        spots += seen.spots;
    }
    return spots > 0 ? std::optional(sum / spots) : std::nullopt;
}

std::optional<double> BodySearch::odds_of_look(std::span<const SeenBy> cameras, const Body& body, const Pose2& pose) {
    const auto seen = agreement(cameras, body, pose);
    return seen ? std::optional(log_odds_of_look(*body.learned, *seen)) : std::nullopt;
}

std::vector<BodyCandidate> BodySearch::candidates(std::span<const SeenBy> cameras, const Body& body) {
    search_floor(cameras, body);
    const double step = 0.3 * body.radius;
    for (BodyCandidate& candidate : candidates_) candidate = climb(cameras, body, candidate, step, coarse_halvings, true);
    if (body.placed_by_look()) compare_looks(cameras, body);
    std::erase_if(candidates_, [](const BodyCandidate& c) { return c.score <= 1; });
    std::sort(candidates_.begin(), candidates_.end(), better);
    keep_apart(candidates_, static_cast<std::size_t>(settings_.most_climbs), [&](const BodyCandidate& a, const BodyCandidate& b) {
        const double turn = body.round() ? 0 : std::abs(std::remainder(a.pose.yaw - b.pose.yaw, body.symmetry));
        return std::hypot(a.pose.x - b.pose.x, a.pose.y - b.pose.y) < 0.5 * body.radius && turn < 0.5;
    });
    if (body.placed_by_look()) return candidates_;
    for (BodyCandidate& candidate : candidates_) candidate = finish_climb(cameras, body, candidate, step);
    std::erase_if(candidates_, [](const BodyCandidate& c) { return c.score <= 1; });
    std::sort(candidates_.begin(), candidates_.end(), better);
    return candidates_;
}

void BodySearch::score_again(std::span<const SeenBy> cameras, const Body& body, std::vector<BodyCandidate>& candidates) {
    for (BodyCandidate& candidate : candidates) {
        const double now = score(cameras, body, candidate.pose);
        const bool less = now < candidate.score - 1;
        candidate.score = now;
        if (less && now > 0.5 * settings_.odds_of_clutter) candidate = climb(cameras, body, candidate, 0.2 * body.radius);
    }
    std::erase_if(candidates, [](const BodyCandidate& c) { return c.score <= 1; });
    std::sort(candidates.begin(), candidates.end(), better);
}

std::vector<BodyPlace> BodySearch::places(std::span<const SeenBy> cameras, const Body& body, const std::vector<BodyCandidate>& candidates) {
    constexpr std::size_t most = 4;
    constexpr double least_weight = 0.02;
    std::vector<BodyPlace> places;
    if (candidates.empty()) return places;
    const BodyCandidate& first = candidates[0];
    const double trust = placed_by_shape(cameras, body) ? 1 : trust_in(first.odds);
    const auto weight_of = [&](const BodyCandidate& c) { return std::exp(trust * (c.odds - first.odds) + c.prior - first.prior); };
    double weights = std::exp(trust * (settings_.odds_of_clutter - first.odds) - first.prior);  // that it is none of them
    for (const BodyCandidate& candidate : candidates) weights += weight_of(candidate);
    for (const BodyCandidate& candidate : candidates) {
        const double weight = weight_of(candidate) / weights;
        if (places.size() == most || (!places.empty() && weight < least_weight)) break;
        places.push_back(measure(cameras, body, candidate));
        places.back().weight = weight;
    }
    add_rivals(places, body);
    note_lasting(places[0], body, settings_.lasting);
    return places;
}

double BodySearch::trust_in(double score) const { return std::min(1.0, settings_.most_information / std::max(score, 1.0)); }

/// The best place is as uncertain as all that might be it together.
void BodySearch::add_rivals(std::vector<BodyPlace>& places, const Body& body) {
    double weights = 0;
    Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
    for (const BodyPlace& place : places) {
        const double turn = body.round() ? 0 : std::remainder(place.pose.yaw - places[0].pose.yaw, body.symmetry);
        const Eigen::Vector3d off(place.pose.x - places[0].pose.x, place.pose.y - places[0].pose.y, turn);
        sum += place.weight * (place.covariance - place.by_calibration * place.by_calibration.transpose() + off * off.transpose());
        weights += place.weight;
    }
    places[0].covariance = sum / weights + places[0].by_calibration * places[0].by_calibration.transpose();
}

/// Does any camera show something else where the body would stand?
bool BodySearch::worth_a_look(std::span<const SeenBy> cameras, const Body& body, std::span<const FloorGrid::Box> boxes) const {
    for (std::size_t c = 0; c < cameras.size(); ++c) {
        const FloorGrid::Box& box = boxes[c];
        if (box.empty()) continue;
        const Evidence& evidence = *cameras[c].evidence;
        const Evidence::Sums seen = evidence.box(box.left, box.above, box.right, box.below);
        const double covered = body.share_of_box * static_cast<double>(seen.other + seen.plain);
        double least = settings_.least_other * covered;
        if (body.has_edges) {
            const double by_chance = evidence.clutter * static_cast<double>(seen.other + seen.plain);
            least = std::min(least, settings_.more_than_by_chance * by_chance + settings_.least_samples * settings_.score.pixels_per_sample);
        }
        if (static_cast<double>(seen.other) > least) return true;
    }
    return false;
}

/// The places for a body's search, kept as long as it and the cameras stay the same.
const FloorGrid& BodySearch::grid_of(std::span<const SeenBy> cameras, const Body& body) {
    constexpr std::size_t most_grids = 16;  // kinds of bodies, and sets of cameras with a frame at the same moment
    const FloorGridSettings settings{std::max(coarse_step(body), settings_.least_step), settings_.most_places, settings_.farthest};
    const auto known = std::find_if(grids_.begin(), grids_.end(), [&](const FloorGrid& grid) { return grid.fits(cameras, body, settings); });
    if (known != grids_.end()) {
        std::rotate(grids_.begin(), known, known + 1);  // the one that was not used for the longest time is the last
    } else {
        if (grids_.size() == most_grids) grids_.pop_back();
        grids_.insert(grids_.begin(), FloorGrid())->lay(cameras, body, settings);
    }
    return grids_.front();
}

double BodySearch::coarse_step(const Body& body) const { return (body.placed_by_look() ? settings_.coarse_step_of_look : settings_.coarse_step) * body.radius; }

/// Some spots of the look, in all turns.
void BodySearch::try_looks(std::span<const SeenBy> cameras, const Body& body, const Eigen::Vector2d& place) {
    BodyCandidate best{{place.x(), place.y(), 0}, -1e9};
    for (int turn = 0; turn < turns_of_look; ++turn) {
        const Pose2 pose{place.x(), place.y(), body.symmetry * turn / turns_of_look};
        const double here = coarse_agreement(cameras, body, pose);
        if (here > best.score) best = {pose, here};
    }
    if (best.score > -1e9) by_look_.push_back(best);
}

/// Of some spots of the look.
double BodySearch::coarse_agreement(std::span<const SeenBy> cameras, const Body& body, const Pose2& pose) {
    return agreement(cameras, body, pose, body.learned->look.spots.size() / settings_.coarse_spots + 1).value_or(-1e9);
}

/// The places that were tried lie farther apart than a look is wide: each to where some spots agree best nearby.
void BodySearch::align_looks(std::span<const SeenBy> cameras, const Body& body) {
    for (BodyCandidate& candidate : by_look_) {
        for (const double part : {0.5, 0.25}) {
            const double off = part * coarse_step(body), turn = part * body.symmetry / turns_of_look;
            for (const Eigen::Vector3d& by : steps_around(off, turn)) {
                const Pose2 pose = moved(candidate.pose, by);
                const double here = coarse_agreement(cameras, body, pose);
                if (here > candidate.score) candidate = {pose, here};
            }
        }
    }
}

/// All places at first, then the best of each neighbourhood.
void BodySearch::search_floor(std::span<const SeenBy> cameras, const Body& body) {
    candidates_.clear();
    by_look_.clear();
    const FloorGrid& grid = grid_of(cameras, body);
    const int turns = body.round() ? 1 : static_cast<int>(std::lround(body.symmetry / std::numbers::pi * 6));
    const double middle_turn = 0.5 * body.symmetry * (turns - 1) / turns;
    for (const FloorGrid::Patch& patch : grid.patches()) {
        bool prepared = false;
        for (std::size_t p = patch.begin; p < patch.end; ++p) {
            if (!worth_a_look(cameras, body, grid.boxes(p))) continue;
            const Eigen::Vector2d& place = grid.places()[p];
            const Eigen::Vector2d& around = turns > 1 ? place : patch.middle;  // with all turns the whole patch is too large
            if (!prepared || turns > 1) prepare_near(cameras, body, {around.x(), around.y(), middle_turn});
            prepared = true;
            BodyCandidate best{{place.x(), place.y(), 0}, 0};
            for (int turn = 0; turn < turns; ++turn) {
                const Pose2 pose{place.x(), place.y(), body.symmetry * turn / turns};
                const double here = score_near(cameras, body, pose, true);
                if (here > best.score) best = {pose, here};
            }
            if (best.score > 1) candidates_.push_back(best);
            if (body.placed_by_look()) try_looks(cameras, body, place);
        }
    }
    const auto near = [&](const BodyCandidate& a, const BodyCandidate& b) {
        return std::hypot(a.pose.x - b.pose.x, a.pose.y - b.pose.y) < (body.placed_by_look() ? 0.6 : 1.2) * body.radius;
    };
    const auto most = static_cast<std::size_t>(body.placed_by_look() ? settings_.most_by_look : settings_.most_climbs);
    const auto keep_best = [&](std::vector<BodyCandidate>& places, std::size_t count) {
        std::sort(places.begin(), places.end(), better);
        keep_apart(places, count, near);
    };
    keep_best(by_look_, settings_.most_aligned);
    align_looks(cameras, body);
    for (auto* places : {&candidates_, &by_look_}) keep_best(*places, most);
}

/// Places found by how much differs, turned as the look agrees best; the best of them are moved to where it agrees.
void BodySearch::compare_looks(std::span<const SeenBy> cameras, const Body& body) {
    constexpr int turns = 12;
    for (BodyCandidate& candidate : candidates_) {
        BodyCandidate best{candidate.pose, score(cameras, body, candidate.pose)};
        for (int i = 1; i < turns && !body.round(); ++i) {
            const Pose2 pose = moved(candidate.pose, {0, 0, body.symmetry * i / turns});
            const double here = score(cameras, body, pose);
            if (here > best.score) best = {pose, here};
        }
        candidate = best;
    }
    for (BodyCandidate& candidate : by_look_) {
        candidate.score = score(cameras, body, candidate.pose);
        candidates_.push_back(candidate);
    }
    std::sort(candidates_.begin(), candidates_.end(), better);
    candidates_.resize(std::min(candidates_.size(), static_cast<std::size_t>(settings_.most_by_look)));
    for (BodyCandidate& candidate : candidates_) candidate = climb(cameras, body, candidate, 0.2 * body.radius);
    std::sort(candidates_.begin(), candidates_.end(), better);
    for (std::size_t i = 0; i < std::min(candidates_.size(), settings_.most_from_beside); ++i)
        candidates_[i] = climb_from_beside(cameras, body, candidates_[i]);
}

/// A look has narrow peaks: beside the one that was climbed there may be a higher one.
BodyCandidate BodySearch::climb_from_beside(std::span<const SeenBy> cameras, const Body& body, BodyCandidate best) {
    constexpr int most_rounds = 3;
    const double off = 0.3 * body.radius, turn = 0.3, step = 0.15 * body.radius;
    for (int round = 0; round < most_rounds; ++round) {
        const BodyCandidate from = best;
        for (const Eigen::Vector3d& by : steps_around(off, turn)) {
            const Pose2 beside = moved(from.pose, by);
            const BodyCandidate there = climb(cameras, body, {beside, score(cameras, body, beside), from.prior}, step);
            if (there.score > best.score) best = there;
        }
        if (best.score < from.score + 1) break;
    }
    return best;
}

BodyCandidate BodySearch::near(std::span<const SeenBy> cameras, const Body& body, const Pose2& pose, const Eigen::Matrix3d& spread, bool rough) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(spread.topLeftCorner<2, 2>());
    const Eigen::Vector2d sigma = axes.eigenvalues().cwiseMax(0).cwiseSqrt();
    const double step = std::clamp(sigma.maxCoeff(), 0.05 * body.radius, 0.3 * body.radius);
    const bool coarse = rough && !body.placed_by_look();
    BodyCandidate best{pose, score(cameras, body, pose, coarse)};
    // Known worse than a climb reaches: from several places.
    for (int axis = 0; axis < 2; ++axis) {
        for (double off = -2 * sigma[axis]; sigma[axis] > 0.3 * body.radius && off <= 2 * sigma[axis]; off += 0.5 * body.radius) {
            const Pose2 there = moved(pose, {off * axes.eigenvectors()(0, axis), off * axes.eigenvectors()(1, axis), 0});
            const double here = score(cameras, body, there, coarse);
            if (here > best.score) best = {there, here};
        }
    }
    if (!coarse) return climb(cameras, body, best, step);
    return finish_climb(cameras, body, climb(cameras, body, best, step, coarse_halvings, true), step);
}

/// The last steps after a climb by coarse scores that began with `step`.
BodyCandidate BodySearch::finish_climb(std::span<const SeenBy> cameras, const Body& body, BodyCandidate climbed, double step) {
    climbed.score = score(cameras, body, climbed.pose);
    return climb(cameras, body, climbed, std::ldexp(step, -coarse_halvings - 1), 1);
}

/// Climbs by trying steps along each axis, ever smaller ones.
BodyCandidate BodySearch::climb(std::span<const SeenBy> cameras, const Body& body, BodyCandidate start, double step, int halvings, bool coarse) {
    prepare_near(cameras, body, start.pose);
    for (; halvings >= 0; --halvings, step /= 2) {
        const double turn = body.round() ? 0 : step / body.radius;
        for (int round = 0; round < 6; ++round) {
            bool improved = false;
            for (const Eigen::Vector3d& by : steps_around(step, turn)) {
                if (by.isZero(0)) continue;
                const Pose2 pose = moved(start.pose, by);
                const double here = score_near(cameras, body, pose, coarse);
                if (here <= start.score) continue;
                start = {pose, here, start.prior};
                improved = true;
            }
            if (!improved) break;
        }
    }
    return start;
}

/// Mean and spread of the poses that explain the pictures about as well, by importance sampling around the best one. `trust`: part of the
/// score that counts. `width`: how far away it looks at first, in parts of the body's radius and of the turn after which it looks the same.
BodySearch::Spread BodySearch::spread_around(std::span<const SeenBy> cameras, const Body& body, const BodyCandidate& best, double trust, double width,
                                             int rounds) {
    Spread result;
    Eigen::Vector3d& mean = result.mean;
    Eigen::Matrix3d& spread = result.covariance;
    const double place_sigma = width * body.radius;
    const double turn_sigma = body.round() ? 1e-3 : 0.8 * width * body.symmetry;
    const Eigen::Matrix3d start = Eigen::Vector3d(place_sigma * place_sigma, place_sigma * place_sigma, turn_sigma * turn_sigma).asDiagonal();
    spread = start;
    constexpr double wider = 1.5;       // than what was found: tails are looked at, too
    constexpr double least_alike = 6;   // samples that count about as much: of fewer nobody tells a spread
    constexpr int most_narrowings = 6;  // to half of the widths
    const double least = settings_.least_place_sigma * settings_.least_place_sigma;
    int narrowings = 0;
    for (int round = 0; round < rounds;) {
        const Eigen::LLT<Eigen::Matrix3d> root(wider * wider * spread);
        const Eigen::Matrix3d lower = root.matrixL();
        prepare_near(cameras, body, moved(best.pose, mean));
        Eigen::Vector3d sum = Eigen::Vector3d::Zero();
        Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
        double weights = 0;
        // The best pose is one of the samples when it comes to how many count.
        const double top = std::exp(std::min(0.5 * root.matrixL().solve(mean).squaredNorm(), 12.0));
        double counted = top, squared = top * top;
        const bool last = round + 1 == rounds;  // the ones before only tell where its samples are to be drawn
        for (int i = 0; i < (last ? settings_.spread_samples : settings_.spread_samples / 2); ++i) {
            const Eigen::Vector3d& unit = units_[static_cast<std::size_t>(i + round * settings_.spread_samples)];
            Eigen::Vector3d by = mean + lower * unit;
            if (body.round()) by.z() = 0;
            const double here = score_near(cameras, body, moved(best.pose, by));
            const double weight = std::exp(std::clamp(trust * (here - best.score) + 0.5 * unit.squaredNorm(), -60.0, 12.0));
            weights += weight;
            counted += weight;
            squared += weight * weight;
            sum += weight * by;
            squares += weight * by * by.transpose();
        }
        if (body.placed_by_look() && counted * counted < least_alike * squared) {
            // A look's peak is narrower than the samples lie apart: from its top with closer ones. Where a round before told a spread, that is it.
            if (round > 0 || narrowings == most_narrowings) break;
            ++narrowings;
            spread = start / std::pow(4, narrowings);
            continue;
        }
        ++round;
        if (weights <= 0) break;
        mean = sum / weights;
        spread = squares / weights - mean * mean.transpose();
        spread = 0.5 * (spread + spread.transpose());
        Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(spread);
        spread = axes.eigenvectors() * axes.eigenvalues().cwiseMax(least).asDiagonal() * axes.eigenvectors().transpose();
    }
    return result;
}

/// A place with its covariance: what explains the pictures about as well, what the body's description leaves open, and the calibration.
BodyPlace BodySearch::measure(std::span<const SeenBy> cameras, const Body& body, const BodyCandidate& best) {
    BodyPlace place;
    place.pose = best.pose;
    place.log_ratio = best.score;
    // The middle of what explains the pictures; a look's peak is too sharp for samples: its top.
    constexpr double far = 0.3, near = 0.1;
    const Spread exact = body.placed_by_look() ? Spread() : spread_around(cameras, body, best, 1, near, settings_.spread_rounds - 1);
    const Spread honest = spread_around(cameras, body, best, trust_in(best.score), far, settings_.spread_rounds);
    place.pose = moved(best.pose, exact.mean);
    place.covariance = honest.covariance + (honest.mean - exact.mean) * (honest.mean - exact.mean).transpose();

    // The body's ends, as far as they are seen, and how their pixels move with place, body and calibration.
    double filled = 0;
    double samples = 0;
    Eigen::Matrix2d information = Eigen::Matrix2d::Zero();
    struct End {
        Eigen::Matrix2d by_place;
        Eigen::Matrix<double, 2, 6> by_calibration;
        Eigen::Matrix2d weight;
        std::size_t camera;
    };
    std::vector<End> ends;
    place.seen.assign(cameras.size(), 0);
    for (std::size_t c = 0; c < cameras.size(); ++c) {
        const PlaceScore here = score_place(cameras[c], body, place.pose, settings_.score, memory_);
        if (!here.in_picture || here.log_ratio < 1) continue;
        place.seen[c] = 1;
        filled += here.samples * here.filled;
        place.body_like += here.body_like;
        samples += here.samples;
        // What is not filled is where the body may end earlier than it is said to.
        const double gap = 0.35 * (1 - here.filled);
        const double sideways = std::hypot(body.size_sigma, gap * 2 * body.radius) / 2;
        const double upwards = std::hypot(body.size_sigma, gap * body.height);
        for (const double z : {0.0, body.height}) {
            ViewJacobian jacobian;
            const auto pixel = project_map_point(*cameras[c].view, {place.pose.x, place.pose.y, z}, &jacobian);
            if (!pixel || !cameras[c].view->model.contains(*pixel, -20)) continue;
            End end;
            end.by_place = jacobian.by_point.leftCols<2>();
            end.by_calibration = jacobian.by_calibration(*cameras[c].view, Eigen::Matrix2d(Eigen::Matrix2d::Identity()));
            const Eigen::Vector2d up = jacobian.by_point.col(2);
            const Eigen::Matrix2d noise =
                sideways * sideways * end.by_place * end.by_place.transpose() + upwards * upwards * up * up.transpose() + Eigen::Matrix2d::Identity();
            end.weight = noise.inverse();
            end.camera = c;
            information += end.by_place.transpose() * end.weight * end.by_place;
            ends.push_back(end);
        }
    }
    place.filled = samples > 0 ? filled / samples : 0;
    if (!ends.empty()) {
        const Eigen::Matrix2d inverse = (information + 1e-6 * Eigen::Matrix2d::Identity()).inverse();
        place.covariance.topLeftCorner<2, 2>() += inverse;
        const auto cameras_seen = std::count(place.seen.begin(), place.seen.end(), 1);
        for (std::size_t c = 0; c < cameras.size(); ++c) {
            Eigen::Matrix<double, 2, 6> by = Eigen::Matrix<double, 2, 6>::Zero();
            for (const End& end : ends) {
                if (end.camera == c) by -= inverse * end.by_place.transpose() * end.weight * end.by_calibration;
            }
            place.covariance.topLeftCorner<2, 2>() += by * by.transpose();
            if (cameras_seen == 1 && place.seen[c]) place.by_calibration.topRows<2>() = by;
        }
    }
    const auto look = odds_of_look(cameras, body, place.pose);
    constexpr double any_turn = std::numbers::pi * std::numbers::pi / 3;  // rad^2: any yaw is as good as any other
    if (body.round()) {
        place.covariance.row(2).setZero();
        place.covariance.col(2).setZero();
        place.covariance(2, 2) = any_turn;
    }
    // Where a look tells the direction, gaps do not matter.
    const double gaps = look ? 0 : settings_.turn_of_gaps * (1 - place.filled);
    if (!body.round()) place.covariance(2, 2) += std::pow(gaps + body.size_sigma / body.radius, 2);
    if (const double wider = std::sqrt(place.covariance(2, 2) / any_turn); wider > 1) {
        place.covariance.row(2) /= wider;
        place.covariance.col(2) /= wider;
    }
    double odds = (body.placed_by_look() ? best.score : odds_of_shape(cameras, body, best.pose)) + best.prior - settings_.odds_of_clutter;
    if (look) odds = body.round() ? odds + *look : std::min(*look, place.log_ratio);
    place.probability = 1 / (1 + std::exp(std::clamp(-odds, -500.0, 500.0)));
    return place;
}

}  // namespace roomfix
