#include "roomfix/overhead/overhead_observer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace roomfix {
namespace {

constexpr double most_covered = 0.25;  // of the picture: more is no robot

}  // namespace

OverheadObserver::OverheadObserver(const View& view, const std::vector<SiteRobot>& robots, const OverheadSettings& settings)
    : view_(view),
      shapes_(std::make_shared<RobotShapes>(robots, settings.body)),
      settings_(settings),
      outlines_(view, shapes_, settings),
      bodies_(robots, settings.body),
      body_outlines_(view, shapes_, settings),
      exactness_(robots.size(), settings) {}

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
    for (const FoundOutline& found : outlines_.find(frame.grey, background_, {bodies_, exactness_, expected_, elsewhere_, !colour_background_.empty()})) {
        if (acceptable(found, settings_)) result.observations.push_back(observation_of(found, *shapes_, bodies_.body(found.robot), view_));
    }
    observe_bodies(frame, result);
    if (result.observations.empty()) result.reason = reason_for_nothing();
    result.changed = foreground().covered > most_covered;
    refresh_background(frame.grey);
}

/// Robots that have no outline as exact as their description: by all that their body covers. An outline that stands where the body explains
/// the picture much worse than elsewhere was something else's.
void OverheadObserver::observe_bodies(const PictureView& frame, OverheadResult& result) {
    evidence_.pixels.clear();
    evidence_.with_colours = bodies_.wants_colours();
    if (!frame.colour || colour_background_.empty() || !colour_background_.compare(*frame.colour, evidence_)) return;
    const SeenBy seen{&view_, &evidence_, &outlines_.walls()};
    wanted_.assign(shapes_->robots.size(), 0);
    for (std::size_t r = 0; r < shapes_->robots.size(); ++r) wanted_[r] = !is_many(static_cast<int>(r)) && !(r < elsewhere_.size() && elsewhere_[r]);
    known_.clear();
    // An outline fitted to what is not that solid states millimetres and is centimetres off.
    std::erase_if(result.observations, [&](const SilhouetteObservation& o) {
        if (is_many(o.robot)) return false;
        if (hidden_from(seen, bodies_.body(o.robot), {o.pose.x, o.pose.y}).whole) return true;
        if (bodies_.shows(seen, o.robot, o.pose)) exactness_.note_outline(bodies_.kind(o.robot), o.exact);
        return !exactness_.holds_for(bodies_.kind(o.robot), o.exact);
    });
    for (SilhouetteObservation& o : result.observations) {
        if (is_many(o.robot)) continue;
        o.doubtful = !bodies_.confirms(seen, o.robot, o.pose);
        if (!o.doubtful) wanted_[static_cast<std::size_t>(o.robot)] = 0;
        known_.push_back(known_by_outline(o));
    }
    if (bodies_wanted_) {
        const FrameEvidence evidence = outlines_.evidence(frame.grey, background_);
        const EdgeJudge edges = [&](const BodySighting& sighting) {
            return body_outlines_.edges_for(evidence, sighting, bodies_.standing(), bodies_, expected_, exactness_);
        };
        for (const BodySighting& sighting : bodies_.find({&seen, 1}, wanted_, known_, expected_, edges)) {
            auto outline = std::find_if(result.observations.begin(), result.observations.end(), [&](const auto& o) { return o.robot == sighting.robot; });
            if (outline != result.observations.end() && bodies_.agrees({&seen, 1}, sighting.robot, outline->pose, sighting.place)) continue;
            if (outline != result.observations.end()) result.observations.erase(outline);
            const auto exact = outline_at(frame.grey, sighting, bodies_.standing());
            result.observations.push_back(exact ? *exact : observation_of(sighting, bodies_.body(sighting.robot), view_));
        }
        result.things = bodies_.things();
        result.absent = bodies_.absent();
        std::erase_if(result.observations, [&](const SilhouetteObservation& o) { return o.doubtful && !bodies_.holds(known_by_outline(o)); });
    }
    colour_background_.refresh(evidence_, 0.02f);
}

std::optional<SilhouetteObservation> OverheadObserver::outline_at(LumaView frame, const BodySighting& sighting, std::span<const KnownRobot> standing) {
    return body_outlines_.at(outlines_.evidence(frame, background_), sighting, standing, bodies_, expected_, exactness_);
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

std::string OverheadObserver::reason_for_nothing() const {
    const std::vector<Component>& components = outlines_.components();
    if (foreground().covered > most_covered) {
        return fmt::format("{:.0f} % of the picture changed at once: the light was switched, the camera was moved, or something fills the view",
                           100 * foreground().covered);
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
        dilate_rows(foreground().mask, scratch_, first, first + rows);
        dilate_rows(foreground().mask, scratch_, 0, first + rows - frame.height);
    }
    for (const FoundOutline& found : outlines_.found()) {
        const PixelBox box = box_around(found.fit.silhouette.polygon());
        const Eigen::Vector2d margin = 0.5 * (box.high - box.low);
        const auto column = [&](double x) { return static_cast<int>(std::clamp(x, 0.0, frame.width - 1.0)); };
        for (int i = 0; i < rows; ++i) {
            const int y = (first + i) % frame.height;
            if (y < box.low.y() - margin.y() || y > box.high.y() + margin.y()) continue;
            scratch_.set_run(y, column(box.low.x() - margin.x()), column(box.high.x() + margin.x()) + 1);
        }
    }
    background_.refresh(frame, foreground(), scratch_);
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
