#include "roomfix/overhead/body_things.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "roomfix/overhead/body_choice.hpp"

namespace roomfix {
namespace {

/// The most that a thing that nobody expects explains of what a robot at a pose leaves.
double most_of_things(BodyScene& scene, int robot, const Pose2& pose) {
    double most = 0;
    for (std::size_t kind = scene.kinds(); kind < scene.bodies.size(); ++kind) {
        for (const BodyCandidate& candidate : scene.candidates[kind]) {
            if (scene.expected.prior_of_thing(candidate.pose) || scene.stand_in_each_other(scene.body(robot), pose, scene.bodies[kind], candidate.pose))
                continue;
            most = std::max(most, scene.search.score(scene.moment(), scene.bodies[kind], candidate.pose));
        }
    }
    return most;
}

/// Volume of an upright cylinder about as wide as a body.
double volume(double radius, double height) { return std::numbers::pi * radius * radius * height; }

/// Nats by which what may be a robot or a thing is likelier to be the robot.
double odds_against_thing(const BodyScene& scene, int robot, std::size_t thing) {
    const Body& a = scene.body(robot);
    const Body& b = scene.bodies[thing];
    const double width_a = std::sqrt(a.radius * a.inner_radius), width_b = std::sqrt(b.radius * b.inner_radius);
    const double common = volume(std::min(width_a, width_b), std::min(a.height, b.height));
    const double alike = common / (volume(width_a, a.height) + volume(width_b, b.height) - common);
    return scene.settings.odds_of_thing + scene.settings.odds_if_alike * alike * alike;
}

/// May a robot that is missing stand where a thing seems to?
bool may_be_missing_robot(const BodyScene& scene, const Body& thing, const Pose2& pose) {
    for (std::size_t r = 0; r < scene.open.size(); ++r) {
        if (!scene.is_missing_robot(static_cast<int>(r))) continue;
        const auto& candidates = scene.candidates[scene.kind_of[r]];
        const bool in_its_way = std::any_of(candidates.begin(), candidates.end(), [&](const BodyCandidate& c) {
            return scene.stand_in_each_other(scene.bodies[scene.kind_of[r]], c.pose, thing, pose);
        });
        if (in_its_way) return true;
    }
    return false;
}

/// The body of a thing's candidate; as many as there are bodies where it is none.
std::size_t kind_of_thing(const BodyScene& scene, const BodyCandidate& thing) {
    std::size_t kind = scene.kinds();
    for (; kind < scene.bodies.size(); ++kind) {
        const auto& candidates = scene.candidates[kind];
        if (!candidates.empty() && &thing >= candidates.data() && &thing < candidates.data() + candidates.size()) break;
    }
    return kind;
}

/// A thing takes its pixels out of what is left, if it is no clutter and stands in no robot. In any case it is no candidate any more.
bool settle_thing(BodyScene& scene, const BodyCandidate& thing) {
    const std::size_t kind = kind_of_thing(scene, thing);
    if (kind == scene.bodies.size()) return false;
    auto& candidates = scene.candidates[kind];
    BodyPlace place = scene.search.measure(scene.moment(), scene.bodies[kind], thing);
    const int number = static_cast<int>(scene.robots + kind - scene.kinds());
    candidates.erase(candidates.begin() + (&thing - candidates.data()));
    const double rarity = scene.expected.prior_of_thing(place.pose) ? 0 : scene.settings.rarity_of_things;
    const double odds = place.log_ratio - scene.settings.search.odds_of_clutter - rarity;
    if (odds < 0 || scene.in_the_way(scene.bodies[kind], number, place.pose)) return false;
    place.probability = 1 / (1 + std::exp(-odds));
    scene.things.push_back(place);
    scene.stand(number, place.pose);
    return true;
}

}  // namespace

void look_for_things(BodyScene& scene, bool everywhere) {
    for (std::size_t kind = scene.kinds(); kind < scene.bodies.size(); ++kind) {
        scene.candidates[kind].clear();
        for (const PoseObservation& thing : scene.expected.things()) {
            const BodyCandidate found = scene.search.near(scene.moment(), scene.bodies[kind], thing.pose, thing.covariance);
            if (found.score > 1) scene.candidates[kind].push_back(found);
        }
        if (everywhere) scene.search_everywhere(kind);
    }
}

const BodyCandidate* thing_instead_of(BodyScene& scene, int robot, const Pose2& pose, double score, bool same_pixels) {
    const BodyCandidate* best = nullptr;
    std::size_t best_kind = 0;
    for (std::size_t kind = scene.kinds(); kind < scene.bodies.size(); ++kind) {
        for (const BodyCandidate& thing : scene.candidates[kind]) {
            if (best && thing.score <= best->score) continue;
            const double apart = std::hypot(thing.pose.x - pose.x, thing.pose.y - pose.y);
            const bool near = apart <= scene.body(robot).radius + scene.bodies[kind].radius;
            if (!near && !(same_pixels &&
                           covered_part(scene.moment(), scene.body(robot), pose, scene.bodies[kind], thing.pose, scene.memory) >= scene.settings.same_pixels))
                continue;
            best = &thing;
            best_kind = kind;
        }
    }
    if (!best) return nullptr;
    const double trust = scene.search.trust_in(best->score);
    const double prior = std::max(scene.expected.prior_of(robot, pose), 0.0);
    const double colours = std::max(scene.search.odds_of_look(scene.moment(), scene.body(robot), pose).value_or(0), 0.0);
    // Where a robot is missing, what was seen there before may have been the robot.
    const double before = scene.is_missing_robot(robot) ? 0 : scene.expected.prior_of_thing(best->pose).value_or(0);
    const double lead = trust * (best->score - score) + before - odds_against_thing(scene, robot, best_kind) - prior - colours;
    const double clutter = scene.settings.search.odds_of_clutter;
    if (lead + std::max(trust * score + prior - clutter, 0.0) <= 0) return nullptr;  // not even if the robot stands elsewhere
    scene.try_away(scene.body(robot), pose);
    // Who is known by colours is hardly taken for a thing's part: then a thing beside the robot is as likely as one in its place.
    const double rarity = scene.body(robot).has_look() ? odds_against_thing(scene, robot, best_kind) : scene.settings.rarity_of_things;
    const double thing_behind = trust * most_of_things(scene, robot, pose) - clutter - rarity;
    scene.left.put_back();
    // One thing may cover what several robots show.
    const double others = explained_beside(scene, robot, best_kind, best->pose, trust) - explained_beside(scene, robot, scene.kind(robot), pose, trust);
    return lead - std::max(thing_behind, 0.0) + others > 0 ? best : nullptr;
}

bool may_be_other_robot(BodyScene& scene, int robot, const BodyCandidate& thing) {
    const std::size_t thing_kind = kind_of_thing(scene, thing);
    for (std::size_t r = 0; r < scene.open.size(); ++r) {
        const int other = static_cast<int>(r);
        if (!scene.open[r] || scene.kind_of[r] == scene.kind(robot)) continue;
        for (const BodyCandidate& there : scene.candidates[scene.kind_of[r]]) {
            if (there.odds + scene.expected.prior_of(other, there.pose) <= 0) continue;
            if (!scene.stand_in_each_other(scene.body(other), there.pose, scene.bodies[thing_kind], thing.pose)) continue;
            if (!thing_instead_of(scene, other, there.pose, there.score, scene.expected.prior_of(other, there.pose) <= 0)) return true;
        }
    }
    return false;
}

const BodyCandidate* known_thing(BodyScene& scene, double least) {
    const BodyCandidate* best = nullptr;
    double most = std::max(least, scene.settings.search.odds_of_clutter);
    for (std::size_t kind = scene.kinds(); kind < scene.bodies.size(); ++kind) {
        for (const BodyCandidate& thing : scene.candidates[kind]) {
            const auto prior = scene.expected.prior_of_thing(thing.pose);
            if (!prior || may_be_missing_robot(scene, scene.bodies[kind], thing.pose)) continue;
            const double odds = scene.search.odds(scene.moment(), scene.bodies[kind], thing.pose) + *prior;
            if (odds <= most) continue;
            most = odds;
            best = &thing;
        }
    }
    return best;
}

void settle_thing_first(BodyScene& scene, const BodyCandidate& thing) {
    if (!settle_thing(scene, thing)) return;
    for (std::size_t kind = 0; kind < scene.kinds(); ++kind) scene.look_where_expected(kind);
}

void settle_things(BodyScene& scene) {
    while (true) {
        const BodyCandidate* best = nullptr;
        for (std::size_t kind = scene.kinds(); kind < scene.bodies.size(); ++kind) {
            for (const BodyCandidate& thing : scene.candidates[kind]) {
                if (!best || thing.score > best->score) best = &thing;
            }
        }
        if (!best) return;
        settle_thing(scene, *best);
    }
}

}  // namespace roomfix
