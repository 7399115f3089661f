#include "roomfix/overhead/body_outlines.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "roomfix/base/decompositions.hpp"
#include "roomfix/overhead/unseen_side.hpp"

namespace roomfix {

BodyOutlines::BodyOutlines(const View& view, std::shared_ptr<const RobotShapes> shapes, const OverheadSettings& settings)
    : view_(view), shapes_(std::move(shapes)), settings_(settings) {
    others_.reserve(64);
}

std::optional<SilhouetteObservation> BodyOutlines::at(const FrameEvidence& evidence, const BodySighting& sighting, std::span<const KnownRobot> standing,
                                                      const BodyObserver& bodies, const Expectation& expected, Exactness& exactness) {
    const int robot = sighting.robot;
    const std::size_t kind = bodies.kind(robot);
    const std::vector<ShapePoints>& parts = shapes_->parts_of(robot);
    if (parts.empty() || parts.front().size_sigma >= soft_size) return std::nullopt;
    if (!exactness.may_be(kind) && !expected.search) return std::nullopt;
    set_nearer(sighting, standing);
    const bool several_parts = parts.size() > 1;
    if (several_parts) {
        try_outlines(evidence, sighting, expected);
        exactness.note_description(kind, likelihood_of_edges());
        if (turned_.empty()) return std::nullopt;
    }
    const std::optional<OutlineFit> best =
        several_parts ? exact_outline_of_parts(evidence, sighting) : best_fit(evidence, sighting, exactness.is_sure(kind), expected.of(robot));
    if (best) {
        SilhouetteObservation outline = observation_of({.robot = robot, .fit = *best}, *shapes_, bodies.body(robot), view_);
        exactness.note_outline(kind, outline.exact);
        if (exactness.holds_for(kind, outline.exact)) return outline;
        if (!several_parts && exactness.own(kind) >= settings_.surely_exact) {
            // The solid that is described to this camera, but not to the others: it stands there, but no more exactly than its body tells.
            outline.covariance += sighting.place.covariance;
            outline.lasting = sighting.place.lasting;
            return outline;
        }
    }
    if (!several_parts || turned_.front().right + settings_.described < 0) return std::nullopt;
    return weighed_outlines(sighting, bodies);
}

double BodyOutlines::edges_for(const FrameEvidence& evidence, const BodySighting& sighting, std::span<const KnownRobot> standing, const BodyObserver& bodies,
                               const Expectation& expected, const Exactness& exactness) {
    if (shapes_->parts_of(sighting.robot).empty()) return 0;  // too many corners for a fit
    set_nearer(sighting, standing);
    try_outlines(evidence, sighting, expected);
    const double described = exactness.described(bodies.kind(sighting.robot));
    return std::log(described * likelihood_of_edges() + 1 - described);
}

/// The best of all places where the body may be.
std::optional<OutlineFit> BodyOutlines::best_fit(const FrameEvidence& evidence, const BodySighting& sighting, bool sure, const PoseObservation* expected) {
    std::optional<OutlineFit> best = fit_near(evidence, sighting.robot, sighting.place, sure, expected);
    for (const BodyPlace& other : sighting.others) {
        const std::optional<OutlineFit> fit = fit_near(evidence, sighting.robot, other, sure, expected);
        if (fit && (!best || fit->score > best->score)) best = fit;
    }
    return best;
}

/// Of a body of several parts, from the likeliest of `turned_`; nothing where it does not convince.
std::optional<OutlineFit> BodyOutlines::exact_outline_of_parts(const FrameEvidence& evidence, const BodySighting& sighting) {
    const std::vector<ShapePoints>& parts = shapes_->parts_of(sighting.robot);
    const OutlineFit exact = fit_outline(evidence, view_, parts, turned_.front().pose, others_, settings_.fit);
    const bool convinces = exact.determined && exact.score >= settings_.least_score && !may_stand_behind(evidence, view_, parts, exact, settings_);
    return convinces ? std::optional(exact) : std::nullopt;
}

void BodyOutlines::set_nearer(const BodySighting& sighting, std::span<const KnownRobot> standing) {
    const auto distance = [&](const Pose2& pose) { return std::hypot(pose.x - view_.position().x(), pose.y - view_.position().y()); };
    others_.clear();
    for (const KnownRobot& other : standing) {
        if (other.robot == sighting.robot || distance(other.pose) > distance(sighting.place.pose)) continue;
        others_.push_back(project_silhouette(view_, shapes_->of(other.robot), other.pose));
    }
}

/// The outline of a robot near a place where its body was found; nothing where it does not convince.
std::optional<OutlineFit> BodyOutlines::fit_near(const FrameEvidence& evidence, int robot, const BodyPlace& place, bool sure, const PoseObservation* expected) {
    const std::vector<ShapePoints>& parts = shapes_->parts_of(robot);
    FoundOutline found{robot};
    found.fit = fit_outline(evidence, view_, parts, place.pose, others_, settings_.fit);
    if (sure) found.fit = weigh_unseen_sides(evidence, view_, parts, found.fit, others_, expected, settings_.fit);
    if (!found.fit.determined || may_stand_behind(evidence, view_, parts, found.fit, settings_)) return std::nullopt;
    if (squared_distance(found.fit, place.pose, place.covariance) > settings_.expected_gate) return std::nullopt;
    const ForegroundMasks masks{&evidence.foreground->mask, &evidence.foreground->shadow};
    found.coarse = coarse_agreement(masks, view_, parts.front(), found.fit.pose, {});
    return acceptable(found, settings_) ? std::optional(found.fit) : std::nullopt;
}

/// The outline of a body of several parts near where its area was found, in all turns where nobody knows how it stands: `turned_`, the likeliest first.
void BodyOutlines::try_outlines(const FrameEvidence& evidence, const BodySighting& sighting, const Expectation& expected) {
    const int robot = sighting.robot;
    rough_ = shapes_->parts_of(robot);
    rough_.front().size_sigma = std::hypot(rough_.front().size_sigma, settings_.rough_parts);
    turned_.clear();
    const PoseObservation* place = expected.of(robot);
    const bool turn_known = place && place->yaw_known && place->covariance(2, 2) < std::pow(settings_.turn_known, 2);
    const double start = turn_known ? place->pose.yaw : sighting.place.pose.yaw;
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

/// How much likelier a robot as described is to show the edges of `turned_` than anything else.
double BodyOutlines::likelihood_of_edges() const {
    double most = 0;
    for (const OutlineFit& fit : turned_) most = std::max(most, std::exp(fit.present));
    return most;
}

/// Tries the outline of `rough_` so far (m) off a place, turned to `yaw`.
void BodyOutlines::fit_parts(const FrameEvidence& evidence, const BodyPlace& place, const Eigen::Vector2d& aside, double yaw) {
    const OutlineFit fit = fit_outline(evidence, view_, rough_, {place.pose.x + aside.x(), place.pose.y + aside.y(), yaw}, others_, settings_.fit);
    if (!fit.determined || !enough_in_view(fit, settings_)) return;
    if (squared_distance(fit, place.pose, place.covariance) > settings_.expected_gate) return;
    const bool known = std::any_of(turned_.begin(), turned_.end(), [&](const OutlineFit& other) {
        const Eigen::Vector3d apart = pose_difference(fit.pose, other.pose, rough_.front());
        return apart.dot((fit.covariance + other.covariance).inverse() * apart) < settings_.expected_gate;
    });
    if (!known) turned_.push_back(fit);
}

/// What `turned_` says together: each outline by how likely it is, and for the rest the place that the body's area tells.
SilhouetteObservation BodyOutlines::weighed_outlines(const BodySighting& sighting, const BodyObserver& bodies) const {
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
    SilhouetteObservation observation = observation_of({.robot = sighting.robot, .fit = best}, *shapes_, bodies.body(sighting.robot), view_);
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

}  // namespace roomfix
