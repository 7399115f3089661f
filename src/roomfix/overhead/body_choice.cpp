#include "roomfix/overhead/body_choice.hpp"

#include <algorithm>
#include <cmath>

#include "roomfix/base/assignment.hpp"

namespace roomfix {
namespace {

/// Nats by which one of two candidates of different kinds that stand in each other's way is the likelier one. How much of the pictures they explain favours a
/// small body inside of a large one that has gaps, their shapes one of nearly the same outline that is half empty: the mean of both errs least.
double likelier_by(const BodyScene& scene, const BodyCandidate& a, const BodyCandidate& b) {
    return 0.5 * (a.odds - b.odds + scene.search.trust_in(std::max(a.score, b.score)) * (a.score - b.score));
}

/// A candidate's odds where robots of other kinds may stand in its way.
double odds_among_kinds(const BodyScene& scene, std::size_t kind, const BodyCandidate& candidate) {
    double odds = candidate.odds;
    for (std::size_t other = 0; other < scene.kinds(); ++other) {
        for (const BodyCandidate& c : scene.candidates[other]) {
            if (other == kind || !scene.stand_in_each_other(scene.bodies[kind], candidate.pose, scene.bodies[other], c.pose)) continue;
            if (const double behind = likelier_by(scene, c, candidate); behind > 0) odds = std::min(odds, c.odds - behind);
        }
    }
    return odds;
}

/// Of robots that may stand at places those that together have the highest total, each at a place of its own.
std::vector<BodyChoice> likeliest_together(const BodyScene& scene, std::vector<BodyChoice> choices) {
    if (choices.empty()) return choices;
    std::stable_sort(choices.begin(), choices.end(), [](const BodyChoice& a, const BodyChoice& b) { return a.total > b.total; });
    std::vector<std::size_t> places;    // choices that are the best of their places
    std::vector<PossiblePair> pairs;    // of robots and places
    std::vector<std::size_t> of_pairs;  // the choice of each
    const double alone = choices[0].total;
    for (std::size_t i = 0; i < choices.size(); ++i) {
        const auto same = std::find_if(places.begin(), places.end(), [&](std::size_t p) {
            return scene.stand_in_each_other(scene.body(choices[i].robot), choices[i].pose, scene.body(choices[p].robot), choices[p].pose);
        });
        const int column = static_cast<int>(same - places.begin());
        if (same == places.end()) places.push_back(i);
        if (std::any_of(pairs.begin(), pairs.end(), [&](const PossiblePair& p) { return p.row == choices[i].robot && p.column == column; })) continue;
        pairs.push_back({choices[i].robot, column, alone - choices[i].total});
        of_pairs.push_back(i);
    }
    const std::vector<int> column_of = assign(static_cast<int>(scene.open.size()), static_cast<int>(places.size()), pairs, alone);
    std::vector<BodyChoice> likeliest;
    for (std::size_t k = 0; k < pairs.size(); ++k) {
        if (column_of[static_cast<std::size_t>(pairs[k].row)] == pairs[k].column) likeliest.push_back(choices[of_pairs[k]]);
    }
    return likeliest;
}

}  // namespace

std::optional<BodyChoice> choose_robot(const BodyScene& scene) {
    std::vector<BodyChoice> choices;  // of every open robot at every candidate of its kind
    for (std::size_t r = 0; r < scene.open.size(); ++r) {
        const auto& candidates = scene.candidates[scene.kind_of[r]];
        for (std::size_t c = 0; c < candidates.size() && scene.open[r]; ++c) {
            const double total = odds_among_kinds(scene, scene.kind_of[r], candidates[c]) + scene.expected.prior_of(static_cast<int>(r), candidates[c].pose);
            if (total > 0) choices.push_back({static_cast<int>(r), c, candidates[c].pose, total});
        }
    }
    const std::vector<BodyChoice> likeliest = likeliest_together(scene, std::move(choices));
    if (likeliest.empty()) return std::nullopt;
    return *std::max_element(likeliest.begin(), likeliest.end(), [](const BodyChoice& a, const BodyChoice& b) { return a.total < b.total; });
}

double outline_score(BodyScene& scene, const KnownRobot& outline, double trust) {
    return trust * scene.search.score(scene.moment(), scene.body(outline.robot), outline.pose) + outline.edges +
           scene.expected.prior_of(outline.robot, outline.pose);
}

double outline_odds(BodyScene& scene, const KnownRobot& outline) {
    const Body& shape = scene.body(outline.robot);
    const double score = scene.search.score(scene.moment(), shape, outline.pose);
    double odds = scene.search.odds(scene.moment(), shape, outline.pose);
    for (const BodyCandidate& other : scene.candidates[scene.kind(outline.robot)]) {
        const double apart = std::hypot(other.pose.x - outline.pose.x, other.pose.y - outline.pose.y);
        if (other.score > score && apart < 2 * shape.inner_radius) odds = std::min(odds, other.odds - (other.score - score));
    }
    return odds + outline.edges + scene.expected.prior_of(outline.robot, outline.pose);
}

double explained_beside(BodyScene& scene, int robot, std::size_t kind, const Pose2& pose, double trust) {
    constexpr std::size_t most_candidates = 6;  // of a kind
    const Body& shape = scene.bodies[kind];
    const bool is_thing = kind >= scene.kinds();
    const double clutter = scene.settings.search.odds_of_clutter;
    scene.try_away(shape, pose);
    double all = 0;
    std::vector<BodyChoice> choices;
    for (std::size_t r = 0; r < scene.open.size(); ++r) {
        const int other = static_cast<int>(r);
        if (!scene.open[r] || (other == robot && !is_thing)) continue;
        const double nowhere = scene.expected.robot(other) ? scene.expected.nowhere() : 0;
        all += nowhere;
        const auto add = [&](const Pose2& there, double nats) {
            if (nats - clutter > nowhere && !scene.stand_in_each_other(shape, pose, scene.body(other), there))
                choices.push_back({other, 0, there, nats - clutter - nowhere});
        };
        for (const KnownRobot& outline : scene.unsure) {
            if (outline.robot == other) add(outline.pose, outline_score(scene, outline, trust));
        }
        const auto& candidates = scene.candidates[scene.kind_of[r]];
        for (std::size_t c = 0; c < std::min(candidates.size(), most_candidates); ++c) {
            const Pose2& there = candidates[c].pose;
            add(there, trust * scene.search.score(scene.moment(), scene.body(other), there) + scene.expected.prior_of(other, there));
        }
        if (other == robot && scene.expected.robot(other)) {
            const BodyCandidate near =
                scene.search.near(scene.moment(), scene.body(other), scene.expected.robot(other)->pose, scene.expected.robot(other)->covariance);
            add(near.pose, trust * near.score + scene.expected.prior_of(other, near.pose));
        }
    }
    for (const BodyChoice& choice : likeliest_together(scene, std::move(choices))) all += choice.total;
    for (const PoseObservation& thing : scene.expected.things()) {
        if (is_at_place(thing, pose) && (is_thing || scene.is_missing_robot(robot))) continue;  // it is this one
        double most = scene.expected.nowhere();
        for (std::size_t other = scene.kinds(); other < scene.bodies.size(); ++other) {
            for (const BodyCandidate& candidate : scene.candidates[other]) {
                if (!is_at_place(thing, candidate.pose) || scene.stand_in_each_other(shape, pose, scene.bodies[other], candidate.pose)) continue;
                most = std::max(
                    most, trust * scene.search.score(scene.moment(), scene.bodies[other], candidate.pose) + scene.expected.odds_here(thing, candidate.pose));
            }
        }
        all += most;
    }
    scene.left.put_back();
    return all;
}

std::vector<KnownRobot>::iterator rather_than(BodyScene& scene, const BodyChoice& choice, bool only_expected) {
    const BodyCandidate& body_there = scene.candidates[scene.kind(choice.robot)][choice.candidate];
    const double trust = scene.search.trust_in(body_there.score);
    auto best = scene.unsure.end();
    std::optional<double> most;
    for (auto u = scene.unsure.begin(); u != scene.unsure.end(); ++u) {
        if (only_expected && !scene.expected.robot(u->robot)) continue;
        const bool elsewhere = std::hypot(u->pose.x - body_there.pose.x, u->pose.y - body_there.pose.y) > scene.body(u->robot).inner_radius;
        const bool in_the_way = scene.stand_in_each_other(scene.body(choice.robot), body_there.pose, scene.body(u->robot), u->pose);
        if (u->robot == choice.robot ? !elsewhere : !in_the_way) continue;
        if (!most) {
            most = trust * body_there.score + scene.expected.prior_of(choice.robot, body_there.pose) +
                   explained_beside(scene, choice.robot, scene.kind(choice.robot), body_there.pose, trust);
        }
        const double all = outline_score(scene, *u, trust) + explained_beside(scene, u->robot, scene.kind(u->robot), u->pose, trust);
        if (all <= *most) continue;
        most = all;
        best = u;
    }
    return best;
}

std::vector<BodyCandidate> rivals_of(const BodyScene& scene, const BodyChoice& choice) {
    const auto& candidates = scene.candidates[scene.kind(choice.robot)];
    const BodyCandidate& own = candidates[choice.candidate];
    long others = -1;
    for (std::size_t r = 0; r < scene.open.size(); ++r) others += scene.open[r] && scene.kind_of[r] == scene.kind(choice.robot);
    std::vector<BodyCandidate> rivals;
    const auto add = [&](const BodyCandidate& candidate) {
        rivals.push_back(candidate);
        rivals.back().prior = scene.expected.prior_of(choice.robot, candidate.pose);
        rivals.back().odds = odds_among_kinds(scene, scene.kind(choice.robot), candidate);
    };
    add(own);
    for (std::size_t c = 0; c < candidates.size(); ++c) {
        if (c == choice.candidate) continue;
        const double apart = std::hypot(candidates[c].pose.x - own.pose.x, candidates[c].pose.y - own.pose.y);
        if (apart > 2 * scene.body(choice.robot).inner_radius && others-- > 0) continue;
        add(candidates[c]);
    }
    return rivals;
}

FixedList<double, most_kinds> compare_kinds(BodyScene& scene, std::size_t own, const BodyPlace& place) {
    constexpr double nearby = 0.1;  // m
    const auto with_odds = [&](std::size_t kind, BodyCandidate candidate) {
        candidate.odds = scene.search.odds_of_shape(scene.moment(), scene.bodies[kind], candidate.pose);
        return candidate;
    };
    const BodyCandidate found = with_odds(own, {place.pose, place.log_ratio});
    FixedList<double, most_kinds> nats;
    for (std::size_t kind = 0; kind < std::min(scene.kinds(), most_kinds); ++kind) {
        if (kind == own) {
            nats.push_back(0);
            continue;
        }
        const BodyCandidate other = scene.search.near(scene.moment(), scene.bodies[kind], place.pose, nearby * nearby * Eigen::Matrix3d::Identity(), true);
        nats.push_back(likelier_by(scene, with_odds(kind, other), found));
    }
    return nats;
}

}  // namespace roomfix
