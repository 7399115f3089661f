#include "roomfix/overhead/overhead_observer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "roomfix/base/decompositions.hpp"

namespace roomfix {
namespace {

constexpr double most_covered = 0.25;  // of the picture: more is no robot

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

OverheadObserver::OverheadObserver(const View& view, const std::vector<SiteRobot>& robots, const OverheadSettings& settings)
    : view_(view), robots_(robots), settings_(settings), bodies_(robots, settings.body) {
    for (const SiteRobot& robot : robots) {
        shapes_.push_back(shape_points(robot.shape, robot.many ? std::max(robot.size_sigma, soft_size) : robot.size_sigma));
        parts_.push_back(robot.learned ? std::vector<ShapePoints>() : outline_parts(robot));
    }
    for (const Cylinder& thing : settings.body.things) shapes_.push_back(shape_points(thing, settings.body.things_sigma));
    exact_.assign(robots.size(), 0.0);
    described_.assign(robots.size(), settings.described);
    exact_to_others_ = exact_;
    found_.reserve(64);
    doubtful_.reserve(64);
    others_.reserve(64);
    starts_.reserve(4096);
}

void OverheadObserver::set_background(BackgroundModel background, ColourBackground colour) {
    background_ = std::move(background);
    colour_background_ = std::move(colour);
    learning_ = false;
}

void OverheadObserver::observe(const PictureView& frame, OverheadResult& result) {
    result.observations.clear();
    result.reason.clear();
    result.things.clear();
    result.absent.clear();
    learn_from(frame);
    observe_outlines(frame.grey);
    for (const Found& found : found_) {
        if (acceptable(found)) result.observations.push_back(observation_of(found));
    }
    observe_bodies(frame, result);
    if (result.observations.empty()) result.reason = reason_for_nothing(finder_.found());
    result.changed = foreground_.covered > most_covered;
    refresh_background(frame.grey);
}

void OverheadObserver::observe_outlines(LumaView frame) {
    find_foreground(frame);
    const auto& components = finder_.find(foreground_.mask, 12);
    const FrameEvidence evidence{frame, &background_, &foreground_, &foreground_.mask};
    found_.clear();
    searches_left_ = settings_.most_searches;
    masks_ = {&foreground_.mask, &foreground_.shadow};
    find_expected(evidence);
    const auto count = std::min(components.size(), static_cast<std::size_t>(settings_.most_blobs));
    for (std::size_t i = 0; i < count; ++i) explain(evidence, components[i]);
    if (found_.size() < 2) return;
    keep_one_at_a_place();
    refit_together(evidence);
}

/// Robots that have no outline as exact as their description: by all that their body covers. An outline that stands where the body explains
/// the picture much worse than elsewhere was something else's.
void OverheadObserver::observe_bodies(const PictureView& frame, OverheadResult& result) {
    evidence_.pixels.clear();
    evidence_.with_colours = bodies_.wants_colours();
    if (!frame.colour || colour_background_.empty() || !colour_background_.compare(*frame.colour, evidence_)) return;
    const SeenBy seen{&view_, &evidence_, &walls_};
    wanted_.assign(robots_.size(), 0);
    for (std::size_t r = 0; r < robots_.size(); ++r) wanted_[r] = !robots_[r].many && !(r < elsewhere_.size() && elsewhere_[r]);
    known_.clear();
    // An outline fitted to what is not that solid states millimetres and is centimetres off.
    std::erase_if(result.observations, [&](const SilhouetteObservation& o) {
        if (robots_[static_cast<std::size_t>(o.robot)].many) return false;
        if (hidden_from(seen, bodies_.body(o.robot), {o.pose.x, o.pose.y}).whole) return true;
        if (bodies_.shows(seen, o.robot, o.pose)) note_outline(o);
        return !is_exact(o);
    });
    for (SilhouetteObservation& o : result.observations) {
        if (robots_[static_cast<std::size_t>(o.robot)].many) continue;
        o.doubtful = !bodies_.confirms(seen, o.robot, o.pose);
        if (!o.doubtful) wanted_[static_cast<std::size_t>(o.robot)] = 0;
        known_.push_back(known_by_outline(o));
    }
    if (bodies_wanted_) {
        const EdgeJudge edges = [&](const BodySighting& sighting) { return edges_for(frame.grey, sighting, bodies_.standing()); };
        for (const BodySighting& sighting : bodies_.find({&seen, 1}, wanted_, known_, expected_, edges)) {
            auto outline = std::find_if(result.observations.begin(), result.observations.end(), [&](const auto& o) { return o.robot == sighting.robot; });
            if (outline != result.observations.end() && bodies_.agrees({&seen, 1}, sighting.robot, outline->pose, sighting.place)) continue;
            if (outline != result.observations.end()) result.observations.erase(outline);
            const auto exact = outline_at(frame.grey, sighting, bodies_.standing());
            result.observations.push_back(exact ? *exact : roomfix::observation_of(sighting, bodies_.body(sighting.robot), view_));
        }
        result.things = bodies_.things();
        result.absent = bodies_.absent();
        std::erase_if(result.observations, [&](const SilhouetteObservation& o) { return o.doubtful && !bodies_.holds(known_by_outline(o)); });
    }
    colour_background_.refresh(evidence_, 0.02f);
}

/// The outline of a robot whose body was found: exact to a fraction of a pixel where the robot is the solid that the site file says.
std::optional<SilhouetteObservation> OverheadObserver::outline_at(LumaView frame, const BodySighting& sighting, std::span<const KnownRobot> standing) {
    const auto r = static_cast<std::size_t>(sighting.robot);
    if (parts_[r].empty() || parts_[r].front().size_sigma >= soft_size) return std::nullopt;
    if (!may_be_exact(sighting.robot) && !expected_.search) return std::nullopt;
    set_nearer(sighting, standing);
    const FrameEvidence evidence{frame, &background_, &foreground_, &foreground_.mask};
    if (parts_[r].size() > 1) return outline_of_parts(evidence, sighting);
    std::optional<OutlineFit> best = fit_near(evidence, sighting.robot, sighting.place);
    for (const BodyPlace& other : sighting.others) {
        const std::optional<OutlineFit> fit = fit_near(evidence, sighting.robot, other);
        if (fit && (!best || fit->score > best->score)) best = fit;
    }
    if (!best) return std::nullopt;
    SilhouetteObservation outline = observation_of({.robot = sighting.robot, .fit = *best});
    note_outline(outline);
    if (is_exact(outline)) return outline;
    if (own_exactness(outline.robot) < settings_.surely_exact) return std::nullopt;
    // The solid that is described to this camera, but not to the others: it stands there, but no more exactly than its body tells.
    outline.covariance += sighting.place.covariance;
    outline.lasting = sighting.place.lasting;
    return outline;
}

/// `others_`: what stands nearer to the camera than a robot.
void OverheadObserver::set_nearer(const BodySighting& sighting, std::span<const KnownRobot> standing) {
    const auto distance = [&](const Pose2& pose) { return std::hypot(pose.x - view_.position().x(), pose.y - view_.position().y()); };
    others_.clear();
    for (const KnownRobot& other : standing) {
        if (other.robot == sighting.robot || distance(other.pose) > distance(sighting.place.pose)) continue;
        others_.push_back(project_silhouette(view_, shapes_[static_cast<std::size_t>(other.robot)], other.pose));
    }
}

/// The outline of a robot near a place where its body was found; nothing where it does not convince.
std::optional<OutlineFit> OverheadObserver::fit_near(const FrameEvidence& evidence, int robot, const BodyPlace& place) {
    const std::vector<ShapePoints>& parts = parts_[static_cast<std::size_t>(robot)];
    Found found{robot};
    found.fit = fit_outline(evidence, view_, parts, place.pose, others_, settings_.fit);
    if (!found.fit.determined || may_stand_behind(evidence, parts, found.fit)) return std::nullopt;
    const Eigen::Vector2d off(found.fit.pose.x - place.pose.x, found.fit.pose.y - place.pose.y);
    const Eigen::Matrix2d spread = (place.covariance + found.fit.covariance).topLeftCorner<2, 2>();
    if (off.dot(spread.inverse() * off) > settings_.expected_gate) return std::nullopt;
    const ForegroundMasks masks{&foreground_.mask, &foreground_.shadow};
    found.coarse = coarse_agreement(masks, view_, parts.front(), found.fit.pose, {});
    return acceptable(found) ? std::optional(found.fit) : std::nullopt;
}

/// The outline of a body of several parts near where its area was found, in all turns where nobody knows how it stands: `turned_`, the likeliest first.
void OverheadObserver::try_outlines(const FrameEvidence& evidence, const BodySighting& sighting) {
    const int robot = sighting.robot;
    rough_ = parts_[static_cast<std::size_t>(robot)];
    rough_.front().size_sigma = std::hypot(rough_.front().size_sigma, settings_.rough_parts);
    turned_.clear();
    const auto expected = std::find_if(expected_.robots.begin(), expected_.robots.end(), [&](const PoseObservation& e) { return e.robot == robot; });
    const bool turn_known = expected != expected_.robots.end() && expected->yaw_known && expected->covariance(2, 2) < std::pow(settings_.turn_known, 2);
    const double start = turn_known ? expected->pose.yaw : sighting.place.pose.yaw;
    const int turns = turn_known || rough_.front().round() ? 1 : settings_.outline_turns;
    const auto try_turns = [&](const Eigen::Vector2d& off) {
        for (int i = 0; i < turns; ++i) fit_parts(evidence, sighting.place, off, start + i * rough_.front().symmetry / turns);
    };
    const auto shown = [&] { return std::any_of(turned_.begin(), turned_.end(), [](const OutlineFit& fit) { return fit.right > 0; }); };
    try_turns(Eigen::Vector2d::Zero());
    for (const BodyPlace& other : sighting.others) fit_parts(evidence, other, Eigen::Vector2d::Zero(), other.pose.yaw);
    if (!shown()) {  // too far away for the edges to be in reach?
        const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(sighting.place.covariance.topLeftCorner<2, 2>());
        for (int axis = 1; axis >= 0 && !shown(); --axis) {
            const Eigen::Vector2d off = settings_.outline_aside * std::sqrt(std::max(axes.eigenvalues()[axis], 0.0)) * axes.eigenvectors().col(axis);
            try_turns(off);
            try_turns(-off);
        }
    }
    std::sort(turned_.begin(), turned_.end(), [](const OutlineFit& a, const OutlineFit& b) { return a.right > b.right; });
}

/// The outline of a body of several parts: exactly as described, or about so.
std::optional<SilhouetteObservation> OverheadObserver::outline_of_parts(const FrameEvidence& evidence, const BodySighting& sighting) {
    const int robot = sighting.robot;
    try_outlines(evidence, sighting);
    note_description(robot);
    if (turned_.empty()) return std::nullopt;
    const std::vector<ShapePoints>& parts = parts_[static_cast<std::size_t>(robot)];
    const OutlineFit exact = fit_outline(evidence, view_, parts, turned_.front().pose, others_, settings_.fit);
    if (exact.determined && exact.score >= settings_.least_score && !may_stand_behind(evidence, parts, exact)) {
        const SilhouetteObservation outline = observation_of({.robot = robot, .fit = exact});
        note_outline(outline);
        if (is_exact(outline)) return outline;
    }
    if (turned_.front().right + settings_.described < 0) return std::nullopt;
    return weighed_outlines(sighting);
}

/// How much likelier a robot as described is to show the edges of `turned_` than anything else.
double OverheadObserver::likelihood_of_edges() const {
    double most = 0;
    for (const OutlineFit& fit : turned_) most = std::max(most, std::exp(fit.present));
    return most;
}

/// Nats by which the edges speak for a robot where its body was found, and not for something else of about its size. They say nothing of robots that
/// are badly described.
double OverheadObserver::edges_for(LumaView frame, const BodySighting& sighting, std::span<const KnownRobot> standing) {
    const auto r = static_cast<std::size_t>(sighting.robot);
    if (parts_[r].empty()) return 0;  // too many corners for a fit
    set_nearer(sighting, standing);
    try_outlines({frame, &background_, &foreground_, &foreground_.mask}, sighting);
    const double described = 1 / (1 + std::exp(-described_[bodies_.kind(sighting.robot)]));
    return std::log(described * likelihood_of_edges() + 1 - described);
}

/// Whether a kind of robot looks as the site file describes it shows over many frames; in some of them something else was found.
void OverheadObserver::note_description(int robot) {
    double& described = described_[bodies_.kind(robot)];
    const double nats = std::log(settings_.surely_robot * likelihood_of_edges() + 1 - settings_.surely_robot);
    described = std::clamp(described + std::min(nats, settings_.described_at_once), -settings_.most_exact, settings_.most_exact);
}

/// Tries the outline of `rough_` so far (m) off a place, turned to `yaw`.
void OverheadObserver::fit_parts(const FrameEvidence& evidence, const BodyPlace& place, const Eigen::Vector2d& aside, double yaw) {
    const OutlineFit fit = fit_outline(evidence, view_, rough_, {place.pose.x + aside.x(), place.pose.y + aside.y(), yaw}, others_, settings_.fit);
    if (!fit.determined || !enough_in_view(fit)) return;
    const Eigen::Vector2d off(fit.pose.x - place.pose.x, fit.pose.y - place.pose.y);
    const Eigen::Matrix2d spread = (place.covariance + fit.covariance).topLeftCorner<2, 2>();
    if (off.dot(spread.inverse() * off) > settings_.expected_gate) return;
    const bool known = std::any_of(turned_.begin(), turned_.end(), [&](const OutlineFit& other) {
        const Eigen::Vector3d apart = pose_difference(fit.pose, other.pose, rough_.front());
        return apart.dot((fit.covariance + other.covariance).inverse() * apart) < settings_.expected_gate;
    });
    if (!known) turned_.push_back(fit);
}

/// What `turned_` says together: each outline by how likely it is, and for the rest the place that the body's area tells.
SilhouetteObservation OverheadObserver::weighed_outlines(const BodySighting& sighting) const {
    const OutlineFit& best = turned_.front();
    const ShapePoints& shape = rough_.front();
    double all = std::exp(-settings_.described - best.right);
    for (const OutlineFit& fit : turned_) all += std::exp(fit.right - best.right);
    const auto add = [&](double weight, const Pose2& pose, const Eigen::Matrix3d& covariance, Eigen::Matrix3d& sum) {
        const Eigen::Vector3d off = pose_difference(best.pose, pose, shape);
        sum += weight * (covariance + off * off.transpose());
    };
    Eigen::Matrix3d area = sighting.place.covariance;
    const double turned = shape.round() ? 2 * std::numbers::pi : shape.symmetry;
    const double any_turn = turned * turned / 12;
    if (area(2, 2) > any_turn) {  // it is turned in any way
        area.row(2).setZero();
        area.col(2).setZero();
        area(2, 2) = any_turn;
    }
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    add(std::exp(-settings_.described - best.right) / all, sighting.place.pose, area, covariance);
    for (const OutlineFit& fit : turned_) add(std::exp(fit.right - best.right) / all, fit.pose, fit.covariance, covariance);
    SilhouetteObservation observation = observation_of({.robot = sighting.robot, .fit = best});
    observation.covariance = covariance;
    observation.kinds = sighting.kinds;
    observation.existence = sighting.place.probability;
    const Eigen::LLT<Eigen::Matrix3d> root(settings_.body.search.lasting * best.pixel_covariance);
    observation.lasting.root = root.matrixL();
    if (shape.round()) observation.lasting.root.row(2).setZero();
    observation.lasting.only_camera = sighting.place.lasting.only_camera;
    for (const OutlineFit& fit : turned_) {
        const double weight = std::exp(fit.right - best.right) / all;
        const std::size_t alike = static_cast<std::size_t>(observation.like_turns);
        if (&fit == &best || weight < 0.05 || observation.hypotheses.size() + alike > observation.hypotheses.capacity()) continue;
        for (std::size_t i = 0; i < alike; ++i) {
            observation.hypotheses.push_back(
                {{fit.pose.x, fit.pose.y, wrap_angle(fit.pose.yaw + static_cast<double>(i) * shape.symmetry)}, weight / static_cast<double>(alike)});
        }
    }
    double weights = 0;
    for (std::size_t i = 0; i < observation.hypotheses.size(); ++i) {
        if (i < static_cast<std::size_t>(observation.like_turns)) observation.hypotheses[i].weight = 1 / all / observation.like_turns;
        weights += observation.hypotheses[i].weight;
    }
    for (PoseHypothesis& hypothesis : observation.hypotheses) hypothesis.weight /= weights;
    return observation;
}

/// Whether a kind of robot is the solid that the site file describes shows over many frames; one in which it is partly hidden says little.
void OverheadObserver::note_exactness(int robot, double nats) {
    double& exact = exact_[bodies_.kind(robot)];
    exact = std::clamp(exact + nats, -settings_.most_exact, settings_.most_exact);
}

void OverheadObserver::note_outline(const SilhouetteObservation& outline) {
    note_exactness(outline.robot, std::clamp(outline.exact, -settings_.exact_at_once, settings_.exact_at_once));
}

bool OverheadObserver::is_exact(const SilhouetteObservation& outline) const {
    return exactness(outline.robot) + std::max(outline.exact - settings_.exact_at_once, 0.0) > settings_.surely_exact;
}

/// Without a background: the median of what was seen, anew after 1, 2, 4, ... 64 frames.
void OverheadObserver::learn_from(const PictureView& frame) {
    if (!learning_) return;
    learner_.add(frame.grey);
    if (frame.colour) colour_frames_.add(*frame.colour);
    ++frames_seen_;
    const bool power_of_two = (frames_seen_ & (frames_seen_ - 1)) == 0;
    if (power_of_two) {
        background_ = learner_.learn(settings_.background);
        colour_background_.learn(colour_frames_.frames());
    }
    if (frames_seen_ >= 64) {
        learning_ = false;
        learner_ = BackgroundLearner();
        colour_frames_ = ColourFrames();
    }
}

void OverheadObserver::find_foreground(LumaView frame) {
    background_.classify_solid(frame, foreground_);
    close(foreground_.mask, scratch_);
}

/// Robots of exact shape that stand where they are expected: one fit each. Those that stand before or behind another one show less: once more,
/// without looking where the others are, if all of them have shown to be the solids described.
void OverheadObserver::find_expected(const FrameEvidence& evidence) {
    doubtful_.clear();
    for (const PoseObservation& expected : expected_.robots) {
        const auto r = static_cast<std::size_t>(expected.robot);
        const ShapePoints& shape = shapes_[r];
        if (robots_[r].many || shape.size_sigma >= soft_size || !available(expected.robot) || found_.size() == found_.capacity()) continue;
        const Eigen::Matrix2d spread = expected.covariance.topLeftCorner<2, 2>();
        if (spread.trace() > settings_.expected_within * settings_.expected_within || !(shape.round() || expected.yaw_known)) continue;
        Found found{expected.robot};
        found.fit = fit_outline(evidence, view_, shape, expected.pose, {}, settings_.fit);
        if (!found.fit.determined || !is_where_expected(found, expected)) continue;
        found.coarse = coarse_agreement(masks_, view_, shape, found.fit.pose, {});
        if (found.fit.score >= settings_.good_score && !may_stand_behind(evidence, std::span(&shape, 1), found.fit) && acceptable(found)) {
            found_.push_back(found);
        } else if (exactness(found.robot) > settings_.surely_exact && found.coarse.filled() > settings_.least_filled) {
            doubtful_.push_back(found);
        }
    }
    for (const Found& doubtful : doubtful_) {
        others_.clear();
        for (const std::vector<Found>* group : {&found_, &doubtful_}) {
            for (const Found& other : *group) {
                if (other.robot != doubtful.robot && meet(other.fit.silhouette, doubtful.fit.silhouette)) others_.push_back(other.fit.silhouette);
            }
        }
        if (others_.empty() || found_.size() == found_.capacity()) continue;
        Found found = doubtful;
        found.fit = fit_outline(evidence, view_, shapes_[static_cast<std::size_t>(found.robot)], found.fit.pose, others_, settings_.fit);
        const auto expected = std::find_if(expected_.robots.begin(), expected_.robots.end(), [&](const PoseObservation& e) { return e.robot == found.robot; });
        if (!found.fit.determined || doubtful.fit.supported > found.fit.supported) found.fit = doubtful.fit;
        if (is_where_expected(found, *expected) && acceptable(found)) found_.push_back(found);
    }
}

bool OverheadObserver::is_where_expected(const Found& found, const PoseObservation& expected) const {
    const Eigen::Vector2d off(found.fit.pose.x - expected.pose.x, found.fit.pose.y - expected.pose.y);
    const Eigen::Matrix2d spread = (expected.covariance + found.fit.covariance).topLeftCorner<2, 2>();
    return off.dot(spread.inverse() * off) <= settings_.expected_gate;
}

/// Finds the robots of one connected piece of foreground, one after the other while there is enough of it left.
void OverheadObserver::explain(const FrameEvidence& evidence, const Component& component) {
    bool whole = true;
    for (Found& found : found_) {
        if (!found.removed) remove_from_remaining(found);  // even far away: its pixels must not be found again
        whole &= !touches(found.coarse.silhouette, component);
    }
    while (found_.size() < found_.capacity()) {
        const Blob blob = measure_blob(masks_, component);
        const Found found = best_robot(evidence, blob, whole);
        if (!acceptable(found)) return;
        found_.push_back(found);
        const double explained = found.coarse.inside.foreground;
        if (blob.certain + 0.3 * blob.shadow - explained < settings_.least_left * found.coarse.inside.area) return;
        remove_from_remaining(found_.back());
        whole = false;
    }
}

/// The robot of the site, not found elsewhere yet, that explains the blob best. `whole`: nothing of it is explained yet.
OverheadObserver::Found OverheadObserver::best_robot(const FrameEvidence& evidence, const Blob& blob, bool whole) {
    Found best;
    best.fit.score = -2;
    double second = -10;  // quality of the next best robot that would do
    for (int robot = 0; robot < static_cast<int>(robots_.size()); ++robot) {
        if (!available(robot) || tried_alike(robot)) continue;
        const Found found = best_fit(evidence, blob, robot, whole);
        const bool better = acceptable(found) != acceptable(best) ? acceptable(found) : quality(found) > quality(best);
        const Found& other = better ? best : found;
        if (acceptable(other)) second = std::max(second, quality(other));
        if (better) best = found;
    }
    // What might as well be another robot of the site is not named.
    if (!best.by_area && quality(best) - second < settings_.least_lead) best.fit.determined = false;
    return best;
}

OverheadObserver::Found OverheadObserver::best_fit(const FrameEvidence& evidence, const Blob& blob, int robot, bool whole) {
    const ShapePoints& shape = shapes_[static_cast<std::size_t>(robot)];
    if (shape.size_sigma >= soft_size) return best_area(evidence, blob, robot);
    Found best{robot};
    best.fit.score = -2;
    // The common case: one robot, all of it in view. Its blob's middle tells where it is.
    if (whole) {
        best.coarse = first_guess(blob, shape);
        const bool too_small = best.coarse.inside.area > 0 && blob.certain + blob.shadow < 0.1 * best.coarse.inside.area;
        if (too_small) return best;
        if (best.coarse.filled() > 0.7 && best.coarse.missing < 0.2 * best.coarse.inside.area) {
            best.fit = fit_outline(evidence, view_, shape, best.coarse.pose, {}, settings_.fit);
            if (best.fit.score > settings_.good_score && !may_stand_behind(evidence, std::span(&shape, 1), best.fit)) return best;
        }
    }
    // The search takes long: so many in a frame, and where bodies are found, too, only for robots that were seen to be exact.
    const bool worth_it = colour_background_.empty() || exactness(robot) > settings_.surely_exact;
    if (!expected_.search_outlines || searches_left_ == 0 || !worth_it) return best;
    --searches_left_;
    // Hidden, cut off, or several in one: look at all places, and let the outlines decide.
    const Blob clearer = look_closer(evidence.frame, blob);
    const Pose2 guess = best.fit.determined ? best.fit.pose : best.coarse.pose;
    const auto found = place_search_.find(evidence, masks_, view_, shape, clearer, guess, settings_.fit, settings_.search);
    if (!found.fit.determined) return best;
    best.coarse = found.coarse;
    best.fit = found.fit;
    return best;
}

/// Could the lower edge that the fit found be the border of the robot's shadow, and the robot stand farther in?
bool OverheadObserver::may_stand_behind(const FrameEvidence& evidence, std::span<const ShapePoints> parts, const OutlineFit& fit) const {
    if (fit.into_shadow < settings_.least_into_shadow) return false;
    const auto behind = pose_behind_shadow(evidence, view_, parts, fit, settings_.fit);
    return behind && fit_outline(evidence, view_, parts, *behind, {}, settings_.fit).score > fit.score - settings_.least_lead;
}

/// Adds what is faint around the blob to the foreground, and measures the blob anew.
Blob OverheadObserver::look_closer(LumaView frame, const Blob& blob) {
    Component box = blob.component;
    const int margin = 8 + std::max(box.right - box.left, box.bottom - box.top) / 4;
    box.left = std::max(box.left - margin, 0);
    box.top = std::max(box.top - margin, 0);
    box.right = std::min(box.right + margin, frame.width - 1);
    box.bottom = std::min(box.bottom + margin, frame.height - 1);
    background_.add_faint(frame, box.left, box.top, box.right, box.bottom, foreground_);
    open(foreground_.mask, scratch_);
    close(foreground_.mask, scratch_);
    if (masks_.foreground != &foreground_.mask) copy_remaining();
    return measure_blob(masks_, box);
}

/// People and loads have no exact outline: the place whose silhouette covers the most foreground.
OverheadObserver::Found OverheadObserver::best_area(const FrameEvidence& evidence, const Blob& blob, int robot) {
    const ShapePoints& shape = shapes_[static_cast<std::size_t>(robot)];
    Found best{robot};
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
CoarsePose OverheadObserver::first_guess(const Blob& blob, const ShapePoints& shape) const {
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

void OverheadObserver::remove_from_remaining(Found& found) {
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
void OverheadObserver::copy_remaining() {
    remaining_ = foreground_.mask;
    remaining_shadow_ = foreground_.shadow;
    for (const Found& found : found_) {
        if (!found.removed) continue;
        clear_region(remaining_, found.coarse.silhouette.polygon());
        clear_region(remaining_shadow_, found.coarse.silhouette.polygon());
    }
    masks_ = {&remaining_, &remaining_shadow_, &taken_};
}

/// How well an outline explains the picture: the edges that agree, and its area less what of it shows nothing.
double OverheadObserver::quality(const Found& found) { return found.fit.score + found.coarse.filled() - found.coarse.missing_part(); }

/// Two solids do not stand at one place: of two outlines that do, the better one stays.
void OverheadObserver::keep_one_at_a_place() {
    constexpr double surely = 0.9;  // of the distance at which their inner circles touch
    for (std::size_t i = 0; i < found_.size(); ++i) {
        for (std::size_t j = i + 1; j < found_.size();) {
            const Found &a = found_[i], &b = found_[j];
            const double apart = std::hypot(a.fit.pose.x - b.fit.pose.x, a.fit.pose.y - b.fit.pose.y);
            const bool both = a.by_area || b.by_area || apart > surely * (bodies_.body(a.robot).inner_radius + bodies_.body(b.robot).inner_radius);
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

/// Fits every outline once more, without looking where other robots are. One that then shows too little, even if only nearer robots may hide it, was not
/// seen.
void OverheadObserver::refit_together(const FrameEvidence& evidence) {
    const auto distance = [&](const Found& found) { return std::hypot(found.fit.pose.x - view_.position().x(), found.fit.pose.y - view_.position().y()); };
    const auto fitted_beside = [&](const Found& found, bool only_nearer) {
        others_.clear();
        bool touched = false;
        for (const Found& other : found_) {
            if (&other == &found || (only_nearer && distance(other) > distance(found))) continue;
            others_.push_back(other.fit.silhouette);
            touched |= meet(other.fit.silhouette, found.fit.silhouette);
        }
        Found again = found;
        if (touched) again.fit = fit_outline(evidence, view_, shapes_[static_cast<std::size_t>(found.robot)], found.fit.pose, others_, settings_.fit);
        return again;
    };
    for (std::size_t i = 0; i < found_.size();) {
        if (found_[i].by_area) {
            ++i;
            continue;
        }
        Found again = fitted_beside(found_[i], false);
        if (!acceptable(again)) again = fitted_beside(found_[i], true);
        if (acceptable(again)) {
            found_[i++] = again;
        } else {
            found_.erase(found_.begin() + static_cast<std::ptrdiff_t>(i));
        }
    }
}

/// Has a robot been tried that looks the same? Which of them it is, others must tell.
bool OverheadObserver::tried_alike(int robot) const {
    for (int other = 0; other < robot; ++other) {
        if (available(other) && look_alike(robots_[static_cast<std::size_t>(other)], robots_[static_cast<std::size_t>(robot)])) return true;
    }
    return false;
}

/// Only shapes have outlines to be fitted, and only where such robots may be the solids described.
bool OverheadObserver::available(int robot) const {
    if (!robots_[static_cast<std::size_t>(robot)].parts.empty() || !may_be_exact(robot)) return false;
    if (static_cast<std::size_t>(robot) < elsewhere_.size() && elsewhere_[static_cast<std::size_t>(robot)]) return false;
    return robots_[static_cast<std::size_t>(robot)].many || std::none_of(found_.begin(), found_.end(), [&](const Found& f) { return f.robot == robot; });
}

bool OverheadObserver::acceptable(const Found& found) const {
    if (!found.fit.determined) return false;
    if (found.by_area) {
        const double in_picture = found.coarse.inside.area / std::max(polygon_area(found.coarse.silhouette.polygon()), 1.0);
        return in_picture > settings_.least_in_picture && found.coarse.filled() > settings_.least_filled &&
               found.coarse.inside.foreground > settings_.least_left * found.coarse.inside.area &&
               found.coarse.inside.shadow < 0.8 * found.coarse.inside.foreground;
    }
    const OutlineFit& fit = found.fit;
    if (!enough_in_view(fit)) return false;
    if (fit.score >= settings_.least_score) return true;
    if (found.coarse.missing >= 0.15 * found.coarse.inside.foreground) return false;
    // Not the exact outline, such as tracks where the box should end, but the robot's whole area and nothing beside it.
    if (found.coarse.filled() >= settings_.surely_filled && fit.supported >= 0.4 * fit.visible) return true;
    // Partly hidden: much of the outline is bare, but what shows agrees.
    const double shown = fit.visible - fit.bare - fit.ambiguous;
    return fit.supported >= settings_.least_hidden * fit.visible && fit.supported >= 0.65 * shown;
}

SilhouetteObservation OverheadObserver::observation_of(const Found& found) const {
    const auto r = static_cast<std::size_t>(found.robot);
    const ShapePoints& shape = robots_[r].parts.empty() ? shapes_[r] : parts_[r].front();
    const OutlineFit& fit = found.fit;
    SilhouetteObservation observation;
    observation.robot = found.robot;
    observation.pose = fit.pose;
    observation.covariance = fit.covariance;
    observation.by_calibration = fit.by_calibration;
    observation.yaw_known = !shape.round();
    observation.support = fit.visible > 0 ? static_cast<double>(fit.supported) / fit.visible : 0;
    observation.edges = fit.edges;
    observation.exact = fit.exact;
    observation.visible = fit.total > 0 ? static_cast<double>(fit.visible) / fit.total : 0;
    const int alike = shape.round() ? 1 : static_cast<int>(std::lround(2 * std::numbers::pi / shape.symmetry));
    observation.like_turns = alike;
    for (int i = 0; i < alike; ++i) {
        observation.hypotheses.push_back({{fit.pose.x, fit.pose.y, wrap_angle(fit.pose.yaw + i * shape.symmetry)}, 1.0 / alike});
    }
    if (parts_[r].size() > 1) {
        for (const auto& corner : outline_of(view_, bodies_.body(found.robot), fit.pose)) observation.outline.push_back(corner.cast<float>());
    } else {
        for (const auto& corner : fit.silhouette.polygon()) observation.outline.push_back(corner.cast<float>());
    }
    return observation;
}

std::string OverheadObserver::reason_for_nothing(const std::vector<Component>& components) const {
    if (foreground_.covered > most_covered) {
        return fmt::format("{:.0f} % of the picture changed at once: the light was switched, the camera was moved, or something fills the view",
                           100 * foreground_.covered);
    }
    if (components.empty()) return "nothing differs from the background";
    return fmt::format("what differs from the background ({} pixels) has not the outline of a robot of this site", components[0].area);
}

/// Where nothing differs, mean and noise follow the picture, but not in and near a robot: its shadow and what is as grey as the
/// floor behind it must not become background. Every eighth pass takes in what differs elsewhere, so that a moved chair
/// becomes background in the end.
void OverheadObserver::refresh_background(LumaView frame) {
    if (learning_) return;
    const int first = background_.refresh_first();
    const int rows = background_.refresh_rows();
    if (background_.passes() % 8 == 7) {
        if (scratch_.width() != frame.width || scratch_.height() != frame.height) scratch_.resize(frame.width, frame.height);
        scratch_.clear();
    } else {
        dilate_rows(foreground_.mask, scratch_, first, first + rows);
        dilate_rows(foreground_.mask, scratch_, 0, first + rows - frame.height);
    }
    for (const Found& found : found_) {
        const PixelBox box = box_around(found.fit.silhouette.polygon());
        const Eigen::Vector2d margin = 0.5 * (box.high - box.low);
        const auto column = [&](double x) { return static_cast<int>(std::clamp(x, 0.0, frame.width - 1.0)); };
        for (int i = 0; i < rows; ++i) {
            const int y = (first + i) % frame.height;
            if (y < box.low.y() - margin.y() || y > box.high.y() + margin.y()) continue;
            scratch_.set_run(y, column(box.low.x() - margin.x()), column(box.high.x() + margin.x()) + 1);
        }
    }
    background_.refresh(frame, foreground_, scratch_);
}

/// A place in all turns that look the same, as far as there is room.
static void add_hypotheses(const BodyPlace& place, const Body& body, SilhouetteObservation& observation) {
    const std::size_t turns = static_cast<std::size_t>(observation.like_turns);
    if (observation.hypotheses.size() + turns > observation.hypotheses.capacity()) return;
    for (int i = 0; i < observation.like_turns; ++i) {
        observation.hypotheses.push_back({{place.pose.x, place.pose.y, wrap_angle(place.pose.yaw + i * body.symmetry)}, place.weight / observation.like_turns});
    }
}

SilhouetteObservation observation_of(const BodySighting& sighting, const Body& body, const View& view) {
    SilhouetteObservation observation;
    const BodyPlace& place = sighting.place;
    observation.robot = sighting.robot;
    observation.pose = place.pose;
    observation.covariance = place.covariance;
    observation.by_calibration = place.by_calibration;
    observation.lasting = place.lasting;
    observation.kinds = sighting.kinds;
    observation.existence = place.probability;
    observation.yaw_known = !body.round();
    observation.support = place.filled;
    observation.visible = 1;
    observation.like_turns = body.round() ? 1 : static_cast<int>(std::lround(2 * std::numbers::pi / body.symmetry));
    add_hypotheses(place, body, observation);
    for (const BodyPlace& other : sighting.others) add_hypotheses(other, body, observation);
    for (const Eigen::Vector2d& corner : outline_of(view, body, place.pose)) observation.outline.push_back(corner.cast<float>());
    return observation;
}

}  // namespace roomfix
