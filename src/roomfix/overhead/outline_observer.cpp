#include "roomfix/overhead/outline_observer.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "roomfix/overhead/unseen_side.hpp"

namespace roomfix {
namespace {

/// True if the silhouette's box and the component's overlap.
bool touches(const Silhouette& silhouette, const Component& component) {
    const PixelBox box = box_around(silhouette.polygon());
    return box.low.x() <= component.right && box.high.x() >= component.left && box.low.y() <= component.bottom && box.high.y() >= component.top;
}

/// Does one of two outlines reach into the other, or nearly?
constexpr double nearly = 12;  // px
bool meet(const Silhouette& a, const Silhouette& b) {
    const auto reaches = [](const Silhouette& one, const Silhouette& into) {
        return std::any_of(one.polygon().begin(), one.polygon().end(), [&](const auto& corner) { return inside_polygon(into.polygon(), corner, nearly); });
    };
    return reaches(a, b) || reaches(b, a);
}

}  // namespace

OutlineObserver::OutlineObserver(const View& view, std::shared_ptr<const RobotShapes> shapes, const OverheadSettings& settings)
    : view_(view), shapes_(std::move(shapes)), settings_(settings) {
    found_.reserve(64);
    doubtful_.reserve(64);
    others_.reserve(64);
    starts_.reserve(4096);
}

const std::vector<FoundOutline>& OutlineObserver::find(LumaView frame, const BackgroundModel& background, const OutlineHints& hints) {
    hints_ = &hints;
    background.classify_solid(frame, foreground_);
    close(foreground_.mask, scratch_);
    const auto& components = finder_.find(foreground_.mask, 12);
    const FrameEvidence evidence = this->evidence(frame, background);
    found_.clear();
    searches_left_ = settings_.most_searches;
    masks_ = {&foreground_.mask, &foreground_.shadow};
    find_expected(evidence);
    const auto count = std::min(components.size(), static_cast<std::size_t>(settings_.most_blobs));
    for (std::size_t i = 0; i < count; ++i) explain(evidence, components[i]);
    if (found_.size() > 1) {
        keep_one_at_a_place();
        refit_together(evidence);
    }
    hints_ = nullptr;
    return found_;
}

/// Robots of exact shape that stand where they are expected: one fit each.
void OutlineObserver::find_expected(const FrameEvidence& evidence) {
    doubtful_.clear();
    for (const PoseObservation& expected : hints_->expected.robots) {
        const ShapePoints& shape = shapes_->of(expected.robot);
        if (shapes_->robots[static_cast<std::size_t>(expected.robot)].many || shape.size_sigma >= soft_size || !available(expected.robot) ||
            found_.size() == found_.capacity())
            continue;
        const Eigen::Matrix2d spread = expected.covariance.topLeftCorner<2, 2>();
        if (spread.trace() > settings_.expected_within * settings_.expected_within || !(shape.round() || expected.yaw_known)) continue;
        FoundOutline found{expected.robot};
        found.fit = fit_outline(evidence, view_, shape, expected.pose, {}, settings_.fit);
        weigh_sides(evidence, found, &expected);
        if (!found.fit.determined || !is_where_expected(found, expected)) continue;
        found.coarse = coarse_agreement(masks_, view_, shape, found.fit.pose, {});
        if (found.fit.score >= settings_.good_score && !may_stand_behind(evidence, view_, std::span(&shape, 1), found.fit, settings_) &&
            acceptable(found, settings_)) {
            found_.push_back(found);
        } else if (hints_->exactness.is_sure(kind(found.robot)) && found.coarse.filled() > settings_.least_filled) {
            doubtful_.push_back(found);
        }
    }
    find_doubtful(evidence);
}

/// Of robots that are as they are described: others may be narrower than that.
void OutlineObserver::weigh_sides(const FrameEvidence& evidence, FoundOutline& found, const PoseObservation* expected) const {
    if (!hints_->exactness.is_sure(kind(found.robot))) return;
    found.fit = weigh_unseen_sides(evidence, view_, {&shapes_->of(found.robot), 1}, found.fit, {}, expected, settings_.fit);
}

/// Those that stand before or behind another one show less: once more, without looking where the others are.
void OutlineObserver::find_doubtful(const FrameEvidence& evidence) {
    for (const FoundOutline& doubtful : doubtful_) {
        others_.clear();
        for (const std::vector<FoundOutline>* group : {&found_, &doubtful_}) {
            for (const FoundOutline& other : *group) {
                if (other.robot != doubtful.robot && meet(other.fit.silhouette, doubtful.fit.silhouette)) others_.push_back(other.fit.silhouette);
            }
        }
        if (others_.empty() || found_.size() == found_.capacity()) continue;
        FoundOutline found = doubtful;
        found.fit = fit_outline(evidence, view_, shapes_->of(found.robot), found.fit.pose, others_, settings_.fit);
        const PoseObservation* expected = hints_->expected.of(found.robot);
        if (!found.fit.determined || doubtful.fit.supported > found.fit.supported) found.fit = doubtful.fit;
        if (is_where_expected(found, *expected) && acceptable(found, settings_)) found_.push_back(found);
    }
}

bool OutlineObserver::is_where_expected(const FoundOutline& found, const PoseObservation& expected) const {
    return squared_distance(found.fit, expected.pose, expected.covariance) <= settings_.expected_gate;
}

/// Finds the robots of one connected piece of foreground, one after the other while there is enough of it left.
void OutlineObserver::explain(const FrameEvidence& evidence, const Component& component) {
    bool whole = true;
    for (FoundOutline& found : found_) {
        if (!found.removed) remove_from_remaining(found);  // even far away: its pixels must not be found again
        whole &= !touches(found.coarse.silhouette, component);
    }
    while (found_.size() < found_.capacity()) {
        const Blob blob = measure_blob(masks_, component);
        const FoundOutline found = best_robot(evidence, blob, whole);
        if (!acceptable(found, settings_)) return;
        found_.push_back(found);
        const double explained = found.coarse.inside.foreground;
        if (blob.certain + 0.3 * blob.shadow - explained < settings_.least_left * found.coarse.inside.area) return;
        remove_from_remaining(found_.back());
        whole = false;
    }
}

/// The robot of the site, not found elsewhere yet, that explains the blob best. `whole`: nothing of it is explained yet.
FoundOutline OutlineObserver::best_robot(const FrameEvidence& evidence, const Blob& blob, bool whole) {
    FoundOutline best;
    best.fit.score = -2;
    double second = -10;  // quality of the next best robot that would do
    for (int robot = 0; robot < static_cast<int>(shapes_->robots.size()); ++robot) {
        if (!available(robot) || tried_alike(robot)) continue;
        const FoundOutline found = best_fit(evidence, blob, robot, whole);
        const bool better = acceptable(found, settings_) != acceptable(best, settings_) ? acceptable(found, settings_) : quality(found) > quality(best);
        const FoundOutline& other = better ? best : found;
        if (acceptable(other, settings_)) second = std::max(second, quality(other));
        if (better) best = found;
    }
    // What might as well be another robot of the site is not named.
    if (!best.by_area && quality(best) - second < settings_.least_lead) best.fit.determined = false;
    return best;
}

FoundOutline OutlineObserver::best_fit(const FrameEvidence& evidence, const Blob& blob, int robot, bool whole) {
    const ShapePoints& shape = shapes_->of(robot);
    if (shape.size_sigma >= soft_size) return best_area(evidence, blob, robot);
    FoundOutline best{robot};
    best.fit.score = -2;
    // The common case: one robot, all of it in view. Its blob's middle tells where it is.
    if (whole) {
        best.coarse = first_guess(blob, shape);
        const bool too_small = best.coarse.inside.area > 0 && blob.certain + blob.shadow < 0.1 * best.coarse.inside.area;
        if (too_small) return best;
        if (best.coarse.filled() > 0.7 && best.coarse.missing < 0.2 * best.coarse.inside.area) {
            best.fit = fit_outline(evidence, view_, shape, best.coarse.pose, {}, settings_.fit);
            weigh_sides(evidence, best, nullptr);
            if (best.fit.score > settings_.good_score && !may_stand_behind(evidence, view_, std::span(&shape, 1), best.fit, settings_)) return best;
        }
    }
    // The search takes long: so many in a frame, and where bodies are found, too, only for robots that were seen to be exact.
    const bool worth_it = !hints_->bodies_too || hints_->exactness.is_sure(kind(robot));
    if (!hints_->expected.search_outlines || searches_left_ == 0 || !worth_it) return best;
    --searches_left_;
    // Hidden, cut off, or several in one: look at all places, and let the outlines decide.
    const Blob clearer = look_closer(evidence, blob);
    const Pose2 guess = best.fit.determined ? best.fit.pose : best.coarse.pose;
    const auto found = place_search_.find(evidence, masks_, view_, shape, clearer, guess, settings_.fit, settings_.search);
    if (!found.fit.determined) return best;
    best.coarse = found.coarse;
    best.fit = found.fit;
    weigh_sides(evidence, best, nullptr);
    return best;
}

/// Adds what is faint around the blob to the foreground, and measures the blob anew.
Blob OutlineObserver::look_closer(const FrameEvidence& evidence, const Blob& blob) {
    Component box = blob.component;
    const int margin = 8 + std::max(box.right - box.left, box.bottom - box.top) / 4;
    box.left = std::max(box.left - margin, 0);
    box.top = std::max(box.top - margin, 0);
    box.right = std::min(box.right + margin, evidence.frame.width - 1);
    box.bottom = std::min(box.bottom + margin, evidence.frame.height - 1);
    evidence.background->add_faint(evidence.frame, box.left, box.top, box.right, box.bottom, foreground_);
    open(foreground_.mask, scratch_);
    close(foreground_.mask, scratch_);
    if (masks_.foreground != &foreground_.mask) copy_remaining();
    return measure_blob(masks_, box);
}

/// People and loads have no exact outline: the place whose silhouette covers the most foreground.
FoundOutline OutlineObserver::best_area(const FrameEvidence& evidence, const Blob& blob, int robot) {
    const ShapePoints& shape = shapes_->of(robot);
    FoundOutline best{robot};
    best.by_area = true;
    best.fit.score = -2;
    search_floor(masks_, view_, shape, blob, static_cast<std::size_t>(settings_.most_starts), starts_);
    for (const CoarsePose& start : starts_) {
        const CoarsePose next = climb(masks_, view_, shape, start, blob, 0.3 * shape.radius);
        if (next.agreement > best.coarse.agreement) best.coarse = next;
    }
    // A speck beside a person is not a person, whoever else its neighbourhood shows.
    const bool enough = blob.certain + blob.shadow > settings_.least_left * best.coarse.inside.area;
    if (enough && best.coarse.silhouette.valid()) best.fit = fit_area(evidence, view_, shape, best.coarse.pose, settings_.fit);
    return best;
}

/// The pose that puts the silhouette on the blob's middle, best turned, then climbed to the best agreement.
CoarsePose OutlineObserver::first_guess(const Blob& blob, const ShapePoints& shape) const {
    const auto place = place_from_centroid(view_, shape, blob.component.centroid);
    CoarsePose best;
    if (!place) return best;
    const int turns = shape.round() ? 1 : (shape.symmetry < 2 ? 3 : 4);
    for (int i = 0; i < turns; ++i) {
        const CoarsePose next = coarse_agreement(masks_, view_, shape, {place->x, place->y, shape.symmetry * i / turns}, blob);
        if (next.agreement > best.agreement) best = next;
    }
    return climb(masks_, view_, shape, best, blob, 0.25 * shape.radius);
}

void OutlineObserver::remove_from_remaining(FoundOutline& found) {
    if (masks_.foreground == &foreground_.mask) {  // the rare case: only now work on a copy
        taken_.resize(foreground_.mask.width(), foreground_.mask.height());
        copy_remaining();
    }
    found.removed = true;
    fill_region(taken_, found.coarse.silhouette.polygon());
    clear_region(remaining_, found.coarse.silhouette.polygon());
    clear_region(remaining_shadow_, found.coarse.silhouette.polygon());
}

/// The foreground without the robots that are explained.
void OutlineObserver::copy_remaining() {
    remaining_ = foreground_.mask;
    remaining_shadow_ = foreground_.shadow;
    for (const FoundOutline& found : found_) {
        if (!found.removed) continue;
        clear_region(remaining_, found.coarse.silhouette.polygon());
        clear_region(remaining_shadow_, found.coarse.silhouette.polygon());
    }
    masks_ = {&remaining_, &remaining_shadow_, &taken_};
}

/// Two solids do not stand at one place: of two outlines that do, the better one stays.
void OutlineObserver::keep_one_at_a_place() {
    constexpr double surely = 0.9;  // of the distance at which their inner circles touch
    for (std::size_t i = 0; i < found_.size(); ++i) {
        for (std::size_t j = i + 1; j < found_.size();) {
            const FoundOutline &a = found_[i], &b = found_[j];
            const double apart = std::hypot(a.fit.pose.x - b.fit.pose.x, a.fit.pose.y - b.fit.pose.y);
            const bool both =
                a.by_area || b.by_area || apart > surely * (hints_->bodies.body(a.robot).inner_radius + hints_->bodies.body(b.robot).inner_radius);
            if (both) {
                ++j;
                continue;
            }
            if (quality(b) > quality(a)) std::swap(found_[i], found_[j]);
            found_.erase(found_.begin() + static_cast<std::ptrdiff_t>(j));
            j = i + 1;
        }
    }
}

/// An outline fitted without looking where others are that meet it; `only_nearer`: others that are nearer to the camera.
FoundOutline OutlineObserver::fitted_beside(const FrameEvidence& evidence, const FoundOutline& found, bool only_nearer) {
    const auto distance = [&](const FoundOutline& one) { return std::hypot(one.fit.pose.x - view_.position().x(), one.fit.pose.y - view_.position().y()); };
    others_.clear();
    bool touched = false;
    for (const FoundOutline& other : found_) {
        if (&other == &found || (only_nearer && distance(other) > distance(found))) continue;
        others_.push_back(other.fit.silhouette);
        touched |= meet(other.fit.silhouette, found.fit.silhouette);
    }
    FoundOutline again = found;
    if (touched) again.fit = fit_outline(evidence, view_, shapes_->of(found.robot), found.fit.pose, others_, settings_.fit);
    return again;
}

/// Fits every outline once more, without looking where other robots are. One that then shows too little, even if only nearer robots may hide it, was not
/// seen.
void OutlineObserver::refit_together(const FrameEvidence& evidence) {
    for (std::size_t i = 0; i < found_.size();) {
        if (found_[i].by_area) {
            ++i;
            continue;
        }
        FoundOutline again = fitted_beside(evidence, found_[i], false);
        if (!acceptable(again, settings_)) again = fitted_beside(evidence, found_[i], true);
        if (acceptable(again, settings_)) {
            found_[i++] = again;
        } else {
            found_.erase(found_.begin() + static_cast<std::ptrdiff_t>(i));
        }
    }
}

/// Has a robot been tried that looks the same? Which of them it is, others must tell.
bool OutlineObserver::tried_alike(int robot) const {
    for (int other = 0; other < robot; ++other) {
        if (available(other) && look_alike(shapes_->robots[static_cast<std::size_t>(other)], shapes_->robots[static_cast<std::size_t>(robot)])) return true;
    }
    return false;
}

/// Only shapes have outlines to be fitted, and only where such robots may be the solids described.
bool OutlineObserver::available(int robot) const {
    if (!shapes_->robots[static_cast<std::size_t>(robot)].parts.empty() || !hints_->exactness.may_be(kind(robot))) return false;
    if (static_cast<std::size_t>(robot) < hints_->elsewhere.size() && hints_->elsewhere[static_cast<std::size_t>(robot)]) return false;
    return shapes_->robots[static_cast<std::size_t>(robot)].many ||
           std::none_of(found_.begin(), found_.end(), [&](const FoundOutline& f) { return f.robot == robot; });
}

}  // namespace roomfix
