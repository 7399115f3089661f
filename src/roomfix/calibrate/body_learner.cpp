#include "roomfix/calibrate/body_learner.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "roomfix/calibrate/body_axes.hpp"
#include "roomfix/overhead/keep_apart.hpp"
#include "roomfix/site/body_parts.hpp"

namespace roomfix {
namespace {

BodySearchSettings search_settings(const BodyLearnerSettings& settings) {
    BodySearchSettings search = settings.search;
    search.most_climbs = settings.candidates;
    return search;
}

class Learner {
public:
    Learner(const std::vector<BodyMoment>& moments, const SiteRobot& rough, const BodyLearnerSettings& settings)
        : moments_(moments), rough_robot_(rough), rough_(body_of(rough)), body_(rough_), settings_(settings), search_(search_settings(settings)) {}

    Result<BodyLesson> learn(const std::function<void(double)>& progress);

private:
    void find_candidates(const std::function<void(double)>& progress);
    /// A guess at where the robot is, and how much it explains (nats).
    struct Try {
        std::vector<BodySight> sights;
        double worth = 0;
    };
    /// All that is learned from a guess.
    struct Lesson {
        Body body;
        std::vector<BodySight> sights;
        double size_sigma = 0.01;
        double worth = 0;
    };
    Result<Try> begin_round_body();
    std::vector<Try> begin_by_look();
    double worth_of(double alike) const;
    Result<Lesson> learn_from(const Try& first);
    double look_alike(const Body& body, std::size_t moment, const Pose2& pose);
    /// The best place of a moment, with the scores (nats) there and at the best other place.
    struct Found {
        Pose2 pose;
        double here = 0, elsewhere = 0;
    };
    Found most_alike(const Body& body, std::size_t moment, int turns);
    bool stays(std::size_t moment, const Pose2& pose);
    bool stands_among(const std::vector<BodySight>& sights, const Pose2& pose) const;
    Body taught_by(const std::vector<BodySight>& sights) const;
    Body taught_by_others(std::size_t moment) const;
    void learn_shape();
    void find_again(bool everywhere);
    void put_straight();
    Agreement agreement_of(const std::vector<double>& values, const Agreement& before) const;
    void learn_agreement(LearnedBody& body);
    Result<void> check() const;

    const std::vector<BodyMoment>& moments_;
    SiteRobot rough_robot_;
    Body rough_;
    Body body_;  // as learned so far
    BodyLearnerSettings settings_;
    BodySearch search_;
    PlaceMemory memory_;
    std::vector<std::vector<BodyCandidate>> candidates_;  // of each moment
    std::vector<BodySight> sights_;
    double size_sigma_ = 0.01;
};

/// Turns of the rough body that it does not tell apart, but its look may.
int turns_of(const Body& rough) { return rough.round() ? 1 : std::max(2, static_cast<int>(std::lround(2 * std::numbers::pi / rough.symmetry))); }

Pose2 turned(const Pose2& pose, int turn, int turns) { return {pose.x, pose.y, wrap_angle(pose.yaw + 2 * std::numbers::pi * turn / turns)}; }

void Learner::find_candidates(const std::function<void(double)>& progress) {
    candidates_.clear();
    for (std::size_t m = 0; m < moments_.size(); ++m) {
        candidates_.push_back(search_.candidates(moments_[m].cameras, rough_));
        std::erase_if(candidates_.back(), [&](const BodyCandidate& c) { return stays(m, c.pose); });
        if (progress) progress(0.5 * static_cast<double>(m + 1) / static_cast<double>(moments_.size()));
    }
}

/// Does what is seen at a place stay there at other moments, too? Then it is something that was put down after the background was taken.
bool Learner::stays(std::size_t moment, const Pose2& pose) {
    constexpr double alike = 0.12;  // log colour, mean of the channels
    constexpr double part = 0.6;    // of what differs from the background there
    constexpr double often = 0.34;  // of the other moments
    std::size_t others = 0;
    std::size_t same = 0;
    for (std::size_t m = 0; m < moments_.size(); ++m) {
        if (m == moment) continue;
        double differs = 0;
        double is_alike = 0;
        for (const SeenBy& camera : moments_[moment].cameras) {
            const auto other = std::find_if(moments_[m].cameras.begin(), moments_[m].cameras.end(), [&](const SeenBy& c) { return c.view == camera.view; });
            if (other == moments_[m].cameras.end()) continue;
            const Evidence& a = *camera.evidence;
            const Evidence& b = *other->evidence;
            cover(*camera.view, rough_.parts, pose, a.width, a.height, a.scale, 2, memory_.mask);
            if (!memory_.mask.valid || a.channels != b.channels) continue;
            const auto channels = static_cast<std::size_t>(a.channels);
            for (const Span& span : memory_.mask.spans) {
                for (int x = span.begin; x < span.end; ++x) {
                    const auto pixel = static_cast<std::size_t>(span.y) * static_cast<std::size_t>(a.width) + static_cast<std::size_t>(x);
                    if (2 * a.pixels[pixel].other < Evidence::certain) continue;
                    double off = 0;
                    for (std::size_t k = 0; k < channels; ++k)
                        off += std::abs(static_cast<double>(a.colours[pixel * channels + k] - b.colours[pixel * channels + k]));
                    differs += 1;
                    is_alike += off < alike * static_cast<double>(channels);
                }
            }
        }
        ++others;
        same += differs > 0 && is_alike > part * differs;
    }
    return same > 1 && static_cast<double>(same) > often * static_cast<double>(others);
}

/// A round body has no direction, and its best places are taken as they are.
Result<Learner::Try> Learner::begin_round_body() {
    Try all;
    for (std::size_t m = 0; m < moments_.size(); ++m) {
        if (candidates_[m].empty() || candidates_[m][0].score < settings_.search.odds_of_clutter) continue;
        all.sights.push_back({m, search_.places(moments_[m].cameras, rough_, {candidates_[m][0]})[0].pose});
    }
    if (all.sights.size() < settings_.least_sights) {
        return Error{
            fmt::format("only {} of {} moments show anything of the robot's size: record it at {} or more places, with a background without it (--background)",
                        all.sights.size(), moments_.size(), settings_.least_sights)};
    }
    return all;
}

/// How well a look explains a moment, nats per spot, mean over the cameras that see enough of it.
double Learner::look_alike(const Body& body, std::size_t moment, const Pose2& pose) {
    double sum = 0;
    int cameras = 0;
    for (const SeenBy& camera : moments_[moment].cameras) {
        const LookScore score = score_look(*camera.view, *camera.evidence, body.learned->look, pose, 0.2, settings_.spots.look, memory_.spots);
        if (score.seen < settings_.spots.look.least_spots) continue;
        sum += score.per_spot;
        ++cameras;
    }
    return cameras > 0 ? sum / cameras : 0;
}

/// Where a moment's picture agrees best with a look, near one of the places that something of the robot's size may be at.
Learner::Found Learner::most_alike(const Body& body, std::size_t moment, int turns) {
    constexpr std::size_t tried = 3;
    std::vector<BodyCandidate> starts;
    for (const BodyCandidate& candidate : candidates_[moment]) {
        for (int turn = 0; turn < turns; ++turn) {
            const Pose2 pose = turned(candidate.pose, turn, turns);
            starts.push_back({pose, look_alike(body, moment, pose)});
        }
    }
    if (starts.empty()) return {};
    const auto better = [](const BodyCandidate& a, const BodyCandidate& b) { return a.score > b.score; };
    std::sort(starts.begin(), starts.end(), better);
    keep_apart(starts, tried,
               [&](const BodyCandidate& a, const BodyCandidate& b) { return std::hypot(a.pose.x - b.pose.x, a.pose.y - b.pose.y) < 0.5 * rough_.radius; });
    for (BodyCandidate& start : starts) {
        for (double step = 0.25 * body.radius; step > 0.02 * body.radius; step /= 2) {
            for (bool improved = true; improved;) {
                improved = false;
                for (int axis = 0; axis < 6; ++axis) {
                    const double by = axis % 2 == 0 ? step : -step;
                    Pose2 pose = start.pose;
                    (axis < 2 ? pose.x : axis < 4 ? pose.y : pose.yaw) += axis < 4 ? by : by / body.radius;
                    const double here = look_alike(body, moment, pose);
                    if (here <= start.score) continue;
                    start = {pose, here};
                    improved = true;
                }
            }
        }
    }
    std::sort(starts.begin(), starts.end(), better);
    Found found{starts[0].pose, search_.score(moments_[moment].cameras, body, starts[0].pose), 0};
    for (const BodyCandidate& start : starts) {
        if (std::hypot(start.pose.x - found.pose.x, start.pose.y - found.pose.y) < 1.2 * rough_.radius) continue;
        found.elsewhere = std::max(found.elsewhere, search_.score(moments_[moment].cameras, body, start.pose));
    }
    return found;
}

/// Is it where it was at another moment? What never moves is no robot.
bool Learner::stands_among(const std::vector<BodySight>& sights, const Pose2& pose) const {
    constexpr double same_place = 1;  // of the body's radius
    return std::any_of(sights.begin(), sights.end(),
                       [&](const BodySight& s) { return std::hypot(s.pose.x - pose.x, s.pose.y - pose.y) < same_place * rough_.radius; });
}

/// One sight after the other is taken for the robot; those whose look is found again in most other moments are tried in full.
std::vector<Learner::Try> Learner::begin_by_look() {
    const int turns = turns_of(rough_);
    const std::vector<LookSpot> spots = spots_on(rough_.parts, settings_.spots.spots / 2);
    std::vector<Try> tries;
    const std::size_t each = std::max<std::size_t>(6, settings_.seeds / std::max<std::size_t>(1, moments_.size()));
    for (std::size_t m = 0; m < moments_.size(); ++m) {
        for (std::size_t k = 0; k < std::min(candidates_[m].size(), each); ++k) {
            Try seed;
            seed.sights.push_back({m, candidates_[m][k].pose});
            Body body = rough_;
            auto learned = std::make_shared<LearnedBody>();
            learned->look = look_from(moments_, seed.sights, spots, false, settings_.spots);
            if (learned->look.spots.size() < spots.size() / 8) continue;
            body.learned = learned;
            const double filled = static_cast<double>(learned->look.spots.size()) / static_cast<double>(spots.size());
            for (std::size_t other = 0; other < moments_.size(); ++other) {
                if (other == m) continue;
                // There is one robot: what is seen at several places of one moment is none.
                const Found found = most_alike(body, other, turns);
                const double alike = filled * (found.here - found.elsewhere);
                if (alike <= 0 || stands_among(seed.sights, found.pose)) continue;
                seed.worth += worth_of(alike);
                seed.sights.push_back({other, found.pose});
            }
            if (seed.sights.size() >= settings_.least_sights) tries.push_back(std::move(seed));
        }
    }
    std::sort(tries.begin(), tries.end(), [](const Try& a, const Try& b) { return a.worth > b.worth; });
    // Others that found the same are no further try.
    keep_apart(tries, settings_.tries, [&](const Try& a, const Try& b) {
        std::size_t same = 0;
        for (const BodySight& s : a.sights) {
            same += std::any_of(b.sights.begin(), b.sights.end(), [&](const BodySight& other) {
                return other.moment == s.moment && std::hypot(other.pose.x - s.pose.x, other.pose.y - s.pose.y) < rough_.radius;
            });
        }
        return 2 * same > std::min(a.sights.size(), b.sights.size());
    });
    return tries;
}

/// What a sight that explains a picture by so many nats counts for: being found at all, and the larger and the more alike, the likelier.
double Learner::worth_of(double alike) const {
    constexpr double little = 0.01;
    return std::min(alike, settings_.enough) + little * alike;
}

void Learner::learn_shape() {
    const Occupancy occupancy(moments_, sights_, rough_, rough_.round(), settings_.occupancy);
    auto parts = occupancy.parts();
    if (parts.empty()) return;
    size_sigma_ = occupancy.size_sigma();
    SiteRobot robot = rough_robot_;
    robot.parts = std::move(parts);
    robot.shape = box_around(robot.parts);
    robot.size_sigma = size_sigma_;
    const auto learned = body_.learned;
    body_ = body_of(robot);
    body_.symmetry = rough_.round() ? 0 : 2 * std::numbers::pi;
    body_.learned = learned;
}

/// The body with the look that some sights teach.
Body Learner::taught_by(const std::vector<BodySight>& sights) const {
    Body body = body_;
    auto learned = std::make_shared<LearnedBody>();
    learned->look = look_from(moments_, sights, spots_on(body_.parts, settings_.spots.spots), rough_.round(), settings_.spots);
    body.learned = std::move(learned);
    body.symmetry = rough_.round() ? 0 : 2 * std::numbers::pi;
    return body;
}

/// The same from all moments but one: what that one shows can be compared with it without being compared with itself.
Body Learner::taught_by_others(std::size_t moment) const {
    std::vector<BodySight> others;
    std::copy_if(sights_.begin(), sights_.end(), std::back_inserter(others), [&](const BodySight& s) { return s.moment != moment; });
    return taught_by(others);
}

/// Looks for the body as it is known by now near its last pose and at all other places of each moment.
void Learner::find_again(bool everywhere) {
    constexpr double odd = 0.4;  // of the usual agreement: with less it is something else
    const int turns = turns_of(rough_);
    struct Again {
        BodySight sight;
        double agreement = 0;
    };
    std::vector<Again> found;
    for (std::size_t m = 0; m < moments_.size(); ++m) {
        const auto& cameras = moments_[m].cameras;
        const Body body = taught_by_others(m);
        std::vector<BodyCandidate> starts;
        for (const BodySight& sight : sights_) {
            if (sight.moment == m) starts.push_back({sight.pose, search_.score(cameras, body, sight.pose)});
        }
        if (everywhere) {
            for (const BodyCandidate& candidate : search_.candidates(cameras, body)) {
                if (!stays(m, candidate.pose)) starts.push_back(candidate);
            }
        } else {
            for (const BodyCandidate& candidate : candidates_[m]) {
                for (int turn = 0; turn < turns; ++turn) {
                    const Pose2 pose = turned(candidate.pose, turn, turns);
                    starts.push_back({pose, search_.score(cameras, body, pose)});
                }
            }
        }
        std::sort(starts.begin(), starts.end(), [](const auto& a, const auto& b) { return a.score > b.score; });
        BodyCandidate best;
        for (std::size_t i = 0; i < std::min<std::size_t>(starts.size(), 3); ++i) {
            const BodyCandidate climbed = search_.climb(cameras, body, starts[i], 0.15 * body.radius);
            if (climbed.score > best.score) best = climbed;
        }
        if (best.score <= settings_.search.odds_of_clutter) continue;
        const Pose2 pose = search_.places(cameras, body, {best})[0].pose;
        found.push_back({{m, pose}, search_.agreement(cameras, body, pose).value_or(0)});
    }
    std::vector<double> agreements;
    for (const Again& again : found) agreements.push_back(again.agreement);
    std::sort(agreements.begin(), agreements.end());
    const double usual = agreements.empty() ? 0 : agreements[agreements.size() / 2];
    sights_.clear();
    for (const Again& again : found) {
        if (rough_.round() || again.agreement > odd * usual) sights_.push_back(again.sight);
    }
}

/// What is learned may lie beside the origin, and be turned, as long as the poses are: its middle becomes the origin, its sides lie along the
/// axes.
void Learner::put_straight() {
    constexpr double reach = 0.3;  // of the radius
    const BodyLook none;
    GroundLine axis;
    if (!rough_.round()) axis = body_axis(body_.parts, body_.has_look() ? body_.learned->look : none, reach * rough_.radius);
    const Eigen::Rotation2Dd turn(-axis.angle);
    Eigen::Vector2d middle = footprint_box(body_.parts, axis.angle).middle();
    if (!rough_.round()) middle.y() = axis.offset;
    for (auto* parts : {&body_.parts, &body_.core}) {
        for (ConvexPart& part : *parts) {
            for (Eigen::Vector3d& p : part.points) p.head<2>() = turn * p.head<2>() - middle;
        }
    }
    for (BodySight& sight : sights_) {
        sight.pose.yaw = wrap_angle(sight.pose.yaw - turn.angle());
        const Eigen::Vector2d by = Eigen::Rotation2Dd(sight.pose.yaw) * middle;
        sight.pose.x += by.x();
        sight.pose.y += by.y();
    }
}

Result<void> Learner::check() const {
    if (sights_.size() < settings_.least_sights) {
        return Error{fmt::format("what looked like the robot is found again in only {} of {} moments: record it at more places, in plain view", sights_.size(),
                                 moments_.size())};
    }
    double way = 0;
    for (const BodySight& a : sights_) {
        for (const BodySight& b : sights_) way = std::max(way, std::hypot(a.pose.x - b.pose.x, a.pose.y - b.pose.y));
    }
    if (way < settings_.least_way * rough_.radius) {
        return Error{fmt::format(
            "the only thing of the robot's size never moved ({:.2f} m in all moments): that might be furniture; record the robot at different places", way)};
    }
    const Box is = box_around(body_.parts);
    const Box said = box_around(rough_.parts);
    const double limit = 3 * rough_robot_.size_sigma;
    const auto off = [&](double a, double b) { return std::abs(a - b) > limit + settings_.most_misfit * b; };
    if (off(is.height, said.height) || off(std::max(is.length, is.width), std::max(said.length, said.width)) ||
        off(std::min(is.length, is.width), std::min(said.length, said.width))) {
        return Error{fmt::format(
            "what moves in these pictures is {:.2f} x {:.2f} x {:.2f} m, the site file says {:.2f} x {:.2f} x {:.2f} m: is it the robot? Then correct its size",
            is.length, is.width, is.height, said.length, said.width, said.height)};
    }
    return {};
}

/// Mean and deviation of values, with what was expected before counting as two of them.
Agreement Learner::agreement_of(const std::vector<double>& values, const Agreement& before) const {
    constexpr double weight = 2;
    const auto n = static_cast<double>(values.size());
    Agreement result;
    result.mean = weight * before.mean;
    for (const double v : values) result.mean += v;
    result.mean /= n + weight;
    double squares = weight * (std::pow(before.sigma, 2) + std::pow(before.mean - result.mean, 2));
    for (const double v : values) squares += std::pow(v - result.mean, 2);
    result.sigma = std::sqrt(squares / (n + weight));
    return result;
}

/// How well the look agrees where the robot stands, and at best elsewhere in the same pictures: what a fix is judged by.
void Learner::learn_agreement(LearnedBody& body) {
    std::vector<double> robot;
    std::vector<double> clutter;
    double mean = 0;
    for (const BodySight& sight : sights_) {
        const auto& cameras = moments_[sight.moment].cameras;
        if (const auto here = search_.agreement(cameras, taught_by_others(sight.moment), sight.pose)) {
            robot.push_back(*here);
            mean += *here;
        }
        std::optional<double> best;
        for (const BodyCandidate& candidate : search_.candidates(cameras, body_)) {
            if (std::hypot(candidate.pose.x - sight.pose.x, candidate.pose.y - sight.pose.y) < 2 * body_.radius) continue;
            const auto elsewhere = search_.agreement(cameras, body_, candidate.pose);
            if (elsewhere && (!best || *elsewhere > *best)) best = elsewhere;
        }
        if (best) clutter.push_back(*best);
    }
    if (robot.empty()) return;
    mean /= static_cast<double>(robot.size());
    body.as_robot = agreement_of(robot, {mean, 0.25 * std::abs(mean) + 0.1});
    body.as_clutter = agreement_of(clutter, {0.2 * mean, 0.15 * std::abs(mean) + 0.1});
}

/// Body and poses in turns.
Result<Learner::Lesson> Learner::learn_from(const Try& first) {
    sights_ = first.sights;
    body_ = rough_;
    for (int i = 0; i < settings_.rounds; ++i) {
        if (i > 0) {
            learn_shape();
            put_straight();
        }
        body_ = taught_by(sights_);
        find_again(i % 2 == 1);
        if (sights_.size() < settings_.least_sights) break;
    }
    if (auto checked = check(); !checked) return checked.error();
    learn_shape();
    put_straight();
    body_ = taught_by(sights_);
    Lesson lesson{body_, sights_, size_sigma_, 0};
    LearnedBody agreed = *body_.learned;
    learn_agreement(agreed);
    lesson.body.learned = std::make_shared<LearnedBody>(agreed);
    // The robot is in most moments, at one place in each, and at others in others: papers of one kind lie all over each picture, single ones are
    // left where they are.
    std::vector<BodySight> places;
    for (const BodySight& sight : sights_) {
        double surely = 1;
        if (!rough_.round()) {
            const auto agreement = search_.agreement(moments_[sight.moment].cameras, taught_by_others(sight.moment), sight.pose);
            surely = 1 / (1 + std::exp(-log_odds_of_look(agreed, agreement.value_or(0))));
        }
        lesson.worth += 0.5 * surely;
        if (stands_among(places, sight.pose)) continue;
        places.push_back(sight);
        lesson.worth += 0.5 * surely;
    }
    return lesson;
}

Result<BodyLesson> Learner::learn(const std::function<void(double)>& progress) {
    find_candidates(progress);
    std::vector<Try> tries;
    if (rough_.round()) {
        auto begun = begin_round_body();
        if (!begun) return begun.error();
        tries.push_back(std::move(*begun));
    } else {
        tries = begin_by_look();
    }
    std::string why = fmt::format(
        "no thing of the robot's size is seen in {} or more of the {} moments and looks alike in them: record it at more places, with a "
        "background without it (--background), and check its shape and size in the site file",
        settings_.least_sights, moments_.size());
    std::optional<Lesson> best;
    for (std::size_t i = 0; i < tries.size(); ++i) {
        auto learned = learn_from(tries[i]);
        if (!learned && i == 0) why = learned.error().message;
        if (learned && (!best || learned->worth > best->worth)) best = std::move(*learned);
        if (progress) progress(0.6 + 0.4 * static_cast<double>(i + 1) / static_cast<double>(tries.size()));
    }
    if (!best) return Error{why};
    body_ = best->body;
    sights_ = best->sights;
    BodyLesson lesson;
    lesson.body = *body_.learned;
    lesson.body.parts = body_.parts;
    lesson.body.size_sigma = best->size_sigma;
    lesson.body.symmetry = body_.symmetry;
    lesson.sights = sights_;
    for (const BodySight& sight : sights_) lesson.per_spot += look_alike(body_, sight.moment, sight.pose) / static_cast<double>(sights_.size());
    for (std::size_t m = 0; m < moments_.size(); ++m) {
        if (std::none_of(sights_.begin(), sights_.end(), [&](const BodySight& s) { return s.moment == m; })) lesson.left_out.push_back(m);
    }
    return lesson;
}

}  // namespace

Result<BodyLesson> learn_body(const std::vector<BodyMoment>& moments, const SiteRobot& rough, const BodyLearnerSettings& settings,
                              const std::function<void(double)>& progress) {
    return Learner(moments, rough, settings).learn(progress);
}

}  // namespace roomfix
