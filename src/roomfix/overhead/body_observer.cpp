#include "roomfix/overhead/body_observer.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "roomfix/overhead/body_things.hpp"

namespace roomfix {

BodyObserver::BodyObserver(const std::vector<SiteRobot>& robots, const BodyObserverSettings& settings) : scene_(robots, settings) {}

const std::vector<BodySighting>& BodyObserver::find(std::span<const SeenBy> cameras, const std::vector<char>& wanted, std::span<const KnownRobot> known,
                                                    const Expectation& expected, const EdgeJudge& edges) {
    found_.clear();
    absent_.clear();
    scene_.strange.clear();
    scene_.things.clear();
    scene_.standing.clear();
    scene_.unsure.clear();
    for (const KnownRobot& robot : known) (robot.sure ? scene_.standing : scene_.unsure).push_back(robot);
    scene_.open = wanted;
    const bool any = std::any_of(wanted.begin(), wanted.end(), [](char w) { return w != 0; });
    if (!any && !(scene_.watches_things && (expected.search || !expected.things.empty()))) return found_;
    scene_.expected.begin(expected, wanted.size());
    scene_.begin(cameras);
    const auto [things_first, kind_in_turn] = turn_of_search(expected.search);
    look_for_things(scene_, things_first);
    for (std::size_t kind = 0; kind < scene_.kinds(); ++kind) {
        scene_.candidates[kind].clear();
        scene_.look_where_expected(kind);
        // Who is missing may stand where another one is expected.
        if (expected.search && (scene_.is_missing(kind) || (kind_in_turn == kind && !scene_.candidates[kind].empty()))) scene_.search_everywhere(kind);
    }
    while (settle_next(!expected.search, edges)) {
    }
    // Who is still missing: again in what the others leave, where the best places are no longer theirs.
    for (std::size_t kind = 0; kind < scene_.kinds() && expected.search; ++kind) {
        if (scene_.is_open(kind)) scene_.search_everywhere(kind);
    }
    for (std::size_t kind = scene_.kinds(); kind < scene_.bodies.size() && expected.search && !things_first; ++kind) scene_.search_everywhere(kind);
    while (settle_next(false, edges)) {
    }
    settle_things(scene_);
    note_absent();
    return found_;
}

/// What is looked for all over the floor before anything is settled. That costs most, since all that is seen is worth a look then: where no robot is missing,
/// it is things in one search, a kind of robots in another one, lest one be followed that is another thing, and the rest only in what nobody explains.
BodyObserver::SearchTurn BodyObserver::turn_of_search(bool search) {
    if (!search) return {};
    bool missing = false;
    for (std::size_t kind = 0; kind < scene_.kinds(); ++kind) missing |= scene_.is_missing(kind);
    const long turn = searches_ % scene_.settings.searches_apart;
    const auto round = static_cast<std::size_t>(searches_ / scene_.settings.searches_apart);
    ++searches_;
    SearchTurn result;
    result.things_first = missing || turn == scene_.settings.searches_apart - 1;
    if (turn == 0 && scene_.kinds() > 0) result.kind = round % scene_.kinds();
    return result;
}

/// Robots of which nothing shows anywhere near where they are expected.
void BodyObserver::note_absent() {
    constexpr double least = 1;  // nats
    for (std::size_t r = 0; r < scene_.open.size(); ++r) {
        const int robot = static_cast<int>(r);
        const PoseObservation* place = scene_.expected.robot(robot);
        if (!scene_.open[r] || !place) continue;
        const BodyCandidate likeliest = scene_.search.near(scene_.moment(), body(robot), place->pose, place->covariance, true);
        if (likeliest.score >= -least) continue;
        const double nats = scene_.search.absence(scene_.moment(), body(robot), likeliest.pose);
        if (nats < -least) absent_.push_back({robot, place->pose, nats});
    }
}

/// Settles what explains most of what is left, a body or an outline, or leaves it out for good. False: nothing is left to be settled.
/// `only_expected`: outlines of robots that nobody expects anywhere wait until the floor has been searched for their bodies.
bool BodyObserver::settle_next(bool only_expected, const EdgeJudge& edges) {
    std::vector<KnownRobot>& unsure = scene_.unsure;
    std::erase_if(unsure,
                  [&](const KnownRobot& k) { return !scene_.open[static_cast<std::size_t>(k.robot)] || scene_.in_the_way(body(k.robot), k.robot, k.pose); });
    scene_.drop_blocked();
    const std::optional<BodyChoice> best = choose_robot(scene_);
    double most = best ? best->total : 0;
    auto outline = unsure.end();
    for (auto u = unsure.begin(); u != unsure.end(); ++u) {
        if (only_expected && !scene_.expected.robot(u->robot)) continue;
        const double odds = outline_odds(scene_, *u);
        if (odds <= most) continue;
        most = odds;
        outline = u;
    }
    if (const BodyCandidate* thing = known_thing(scene_, most)) {
        settle_thing_first(scene_, *thing);
        return true;
    }
    if (best && outline == unsure.end()) {
        outline = rather_than(scene_, *best, only_expected);
        if (outline != unsure.end()) most = outline_score(scene_, *outline);
    }
    if (outline != unsure.end()) {
        settle_outline(outline, most);
        return true;
    }
    if (best) settle_body(*best, edges);
    return best.has_value();
}

/// Its robot stands there, if that is likelier by `nats` than nothing and no thing explains it better.
void BodyObserver::settle_outline(std::vector<KnownRobot>::iterator outline, double nats) {
    const KnownRobot likeliest = *outline;
    scene_.unsure.erase(outline);
    const double own = outline_score(scene_, likeliest) - scene_.expected.prior_of(likeliest.robot, likeliest.pose);
    if (const BodyCandidate* thing = thing_instead_of(scene_, likeliest.robot, likeliest.pose, own, false)) {
        settle_thing_first(scene_, *thing);
        scene_.unsure.push_back(likeliest);
    } else if (nats > scene_.settings.search.odds_of_clutter) {
        scene_.stand(likeliest.robot, likeliest.pose);
    }
}

/// The robot stands there, if no thing explains it better and its edges are a robot's.
void BodyObserver::settle_body(const BodyChoice& choice, const EdgeJudge& edges) {
    const std::size_t kind = this->kind(choice.robot);
    const Body& shape = body(choice.robot);
    auto& candidates = scene_.candidates[kind];
    const BodyCandidate first = candidates[choice.candidate];
    const bool expected_here = scene_.expected.prior_of(choice.robot, first.pose) > 0;
    if (const BodyCandidate* thing = thing_instead_of(scene_, choice.robot, first.pose, first.score, !expected_here)) {
        if (!may_be_other_robot(scene_, choice.robot, *thing)) return settle_thing_first(scene_, *thing);
        candidates.erase(candidates.begin() + static_cast<std::ptrdiff_t>(choice.candidate));
        return;
    }
    const auto places = scene_.search.places(scene_.moment(), shape, rivals_of(scene_, choice));
    BodySighting sighting{choice.robot, places[0], {places.begin() + 1, places.end()}, {}};
    if (!is_robot(sighting, edges)) {
        candidates.erase(candidates.begin() + static_cast<std::ptrdiff_t>(choice.candidate));
        // What is no robot at its likeliest place is none farther along the ray either.
        if (!shape.has_edges) {
            std::erase_if(candidates, [&](const BodyCandidate& c) {
                return covered_part(scene_.moment(), shape, c.pose, shape, first.pose, scene_.memory) >= scene_.settings.same_pixels;
            });
        }
        if (shape.has_edges && static_cast<int>(scene_.strange.size()) > scene_.settings.most_strange) candidates.clear();
        return;
    }
    sighting.kinds = compare_kinds(scene_, kind, sighting.place);
    scene_.stand(choice.robot, sighting.place.pose);
    found_.push_back(std::move(sighting));
}

/// By what its body covers and by its edges. What is as large as a robot but has other edges is remembered as strange; edges may show a robot that hardly
/// differs from what it stands before.
bool BodyObserver::is_robot(BodySighting& sighting, const EdgeJudge& edges) {
    double& probability = sighting.place.probability;
    const double least = scene_.settings.least_probability;
    const bool by_area = probability >= least;
    if (!edges || !body(sighting.robot).has_edges) return by_area;
    const double nats = edges(sighting);
    const double prior = std::max(scene_.expected.prior_of(sighting.robot, sighting.place.pose), 0.0);
    if (by_area && nats + sighting.place.body_like + scene_.settings.odds_of_thing + prior >= 0) return true;
    if (!by_area) {
        const double odds = std::log(std::max(probability, 1e-30) / (1 - probability)) + nats;
        probability = 1 / (1 + std::exp(-odds));
        if (probability >= least) return true;
    }
    scene_.strange.push_back({sighting.robot, sighting.place.pose});
    return false;
}

bool BodyObserver::holds(const KnownRobot& known) const {
    return std::any_of(scene_.standing.begin(), scene_.standing.end(), [&](const KnownRobot& s) {
        return s.robot == known.robot && std::hypot(s.pose.x - known.pose.x, s.pose.y - known.pose.y) < body(known.robot).radius;
    });
}

KnownRobot known_by_outline(const SilhouetteObservation& outline) { return {outline.robot, outline.pose, !outline.doubtful, outline.edges}; }

bool BodyObserver::wants_colours() const {
    return std::any_of(scene_.bodies.begin(), scene_.bodies.end(), [](const Body& body) { return body.has_look(); });
}

bool BodyObserver::confirms(const SeenBy& camera, int robot, const Pose2& pose) {
    const BodyObserverSettings& settings = scene_.settings;
    const PlaceScore score = score_place(camera, body(robot), pose, settings.search.score, scene_.memory);
    return score.in_picture && score.filled > settings.plainly_filled && score.around < settings.plainly_alone &&
           score.log_ratio > settings.search.odds_of_clutter;
}

bool BodyObserver::shows(const SeenBy& camera, int robot, const Pose2& pose) {
    const PlaceScore score = score_place(camera, body(robot), pose, scene_.settings.search.score, scene_.memory);
    return score.in_picture && score.log_ratio > scene_.settings.search.odds_of_clutter;
}

bool BodyObserver::agrees(std::span<const SeenBy> cameras, int robot, const Pose2& pose, const BodyPlace& best) {
    const auto score = [&](const Pose2& at) { return scene_.search.score(cameras, body(robot), at); };
    return score(pose) > score(best.pose) - scene_.settings.outline_loss;
}

}  // namespace roomfix
