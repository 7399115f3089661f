#include "roomfix/overhead/body_scene.hpp"

#include <algorithm>
#include <cmath>

#include "roomfix/overhead/keep_apart.hpp"

namespace roomfix {

BodyScene::BodyScene(const std::vector<SiteRobot>& all_robots, const BodyObserverSettings& all_settings)
    : settings(all_settings), robots(all_robots.size()), kind_of(kinds_of(all_robots)), search(all_settings.search), expected(all_settings.expected) {
    for (std::size_t r = 0; r < robots; ++r) {
        if (kind_of[r] == bodies.size()) bodies.push_back(body_of(all_robots[r]));
    }
    watches_things = std::any_of(all_robots.begin(), all_robots.end(), [](const SiteRobot& r) { return !r.many; });
    for (std::size_t t = 0; t < settings.things.size() && watches_things; ++t) {
        SiteRobot thing;
        thing.shape = settings.things[t];
        thing.size_sigma = settings.things_sigma;
        kind_of.push_back(bodies.size());
        bodies.push_back(body_of(thing));
    }
    candidates.resize(bodies.size());
}

bool BodyScene::is_open(std::size_t kind) const {
    for (std::size_t r = 0; r < open.size(); ++r) {
        if (open[r] && kind_of[r] == kind) return true;
    }
    return false;
}

bool BodyScene::is_missing(std::size_t kind) const {
    for (std::size_t r = 0; r < open.size(); ++r) {
        if (kind_of[r] == kind && is_missing_robot(static_cast<int>(r))) return true;
    }
    return false;
}

int BodyScene::likeliest_of(std::size_t kind, const Pose2& pose) const {
    int best = -1;
    for (std::size_t r = 0; r < open.size(); ++r) {
        if (!open[r] || kind_of[r] != kind) continue;
        if (best < 0 || expected.prior_of(static_cast<int>(r), pose) > expected.prior_of(best, pose)) best = static_cast<int>(r);
    }
    return best;
}

bool BodyScene::stand_in_each_other(const Body& a, const Pose2& at_a, const Body& b, const Pose2& at_b) const {
    return std::hypot(at_a.x - at_b.x, at_a.y - at_b.y) < settings.overlap * (a.inner_radius + b.inner_radius);
}

bool BodyScene::in_the_way(const Body& shape, int robot, const Pose2& pose) const {
    return std::any_of(standing.begin(), standing.end(), [&](const KnownRobot& other) {
        return (other.robot != robot || static_cast<std::size_t>(robot) >= robots) && stand_in_each_other(shape, pose, body(other.robot), other.pose);
    });
}

void BodyScene::begin(std::span<const SeenBy> cameras) {
    left.begin(cameras);
    for (const KnownRobot& robot : standing) take_away(body(robot.robot), robot.pose);
}

void BodyScene::look_where_expected(std::size_t kind) {
    const auto look_at = [&](const PoseObservation& place) {
        const BodyCandidate found = search.near(moment(), bodies[kind], place.pose, place.covariance);
        const bool known = std::any_of(candidates[kind].begin(), candidates[kind].end(), [&](const BodyCandidate& c) {
            return std::hypot(c.pose.x - found.pose.x, c.pose.y - found.pose.y) < settings.search.least_place_sigma;
        });
        if (found.score > 1 && !known) candidates[kind].push_back(found);
    };
    for (std::size_t r = 0; r < open.size(); ++r) {
        const PoseObservation* place = expected.robot(static_cast<int>(r));
        if (open[r] && kind_of[r] == kind && place) look_at(*place);
    }
    for (const PoseObservation& place : expected.nameless()) {
        if (this->kind(place.robot) == kind && is_open(kind)) look_at(place);
    }
    weigh_by_prior(kind);
}

void BodyScene::search_everywhere(std::size_t kind) {
    auto& found = candidates[kind];
    for (const BodyCandidate& candidate : search.candidates(moment(), bodies[kind])) found.push_back(candidate);
    weigh_by_prior(kind);
    keep_apart(found, found.size(), [&](const BodyCandidate& a, const BodyCandidate& b) {
        const double turn = bodies[kind].round() ? 0 : std::abs(std::remainder(a.pose.yaw - b.pose.yaw, bodies[kind].symmetry));
        return std::hypot(a.pose.x - b.pose.x, a.pose.y - b.pose.y) < 0.5 * bodies[kind].radius && turn < 0.5;
    });
}

/// The likeliest first, by what they explain and by where robots are expected.
void BodyScene::weigh_by_prior(std::size_t kind) {
    auto& found = candidates[kind];
    search.weigh(moment(), bodies[kind], found);
    for (BodyCandidate& candidate : found) {
        const int robot = likeliest_of(kind, candidate.pose);
        candidate.prior = robot < 0 ? 0 : expected.prior_of(robot, candidate.pose);
    }
    std::sort(found.begin(), found.end(), [](const BodyCandidate& a, const BodyCandidate& b) { return a.odds + a.prior > b.odds + b.prior; });
}

void BodyScene::stand(int robot, const Pose2& pose) {
    if (static_cast<std::size_t>(robot) < robots) open[static_cast<std::size_t>(robot)] = 0;
    standing.push_back({robot, pose});
    take_away(body(robot), pose);
    for (std::size_t kind = 0; kind < bodies.size(); ++kind) {
        if (kind < kinds() && !is_open(kind)) {
            candidates[kind].clear();
            continue;
        }
        search.score_again(moment(), bodies[kind], candidates[kind]);
        weigh_by_prior(kind);
    }
}

void BodyScene::drop_blocked() {
    for (std::size_t kind = 0; kind < bodies.size(); ++kind) {
        std::erase_if(candidates[kind], [&](const BodyCandidate& c) {
            const bool is_strange = std::any_of(strange.begin(), strange.end(), [&](const KnownRobot& s) {
                return this->kind(s.robot) == kind && stand_in_each_other(bodies[kind], c.pose, bodies[kind], s.pose);
            });
            return is_strange || in_the_way(bodies[kind], -1, c.pose);
        });
    }
}

/// Outlines that have to hold yet and do not stand in this body.
std::span<const StandingBody> BodyScene::outlines_beside(const Body& shape, const Pose2& pose) {
    beside_.clear();
    for (const KnownRobot& outline : unsure) {
        if (!stand_in_each_other(shape, pose, body(outline.robot), outline.pose)) beside_.push_back({&body(outline.robot), outline.pose});
    }
    return beside_;
}

}  // namespace roomfix
