#include "roomfix/overhead/body_observer.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "roomfix/base/assignment.hpp"
#include "roomfix/base/decompositions.hpp"
#include "roomfix/overhead/floor_shadows.hpp"
#include "roomfix/overhead/keep_apart.hpp"

namespace roomfix {

/// Visits the numbers of a mask's pixels in a picture of this width.
template <class Visit>
static void for_each_pixel(const BodyMask& mask, int width, Visit&& visit) {
    for (const Span& span : mask.spans) {
        for (int x = span.begin; x < span.end; ++x) visit(span.y * width + x);
    }
}

BodyObserver::BodyObserver(const std::vector<SiteRobot>& robots, const BodyObserverSettings& settings) : settings_(settings), search_(settings.search) {
    kind_of_ = kinds_of(robots);
    for (std::size_t r = 0; r < robots.size(); ++r) {
        if (kind_of_[r] == bodies_.size()) bodies_.push_back(body_of(robots[r]));
    }
    robots_ = robots.size();
    watches_things_ = std::any_of(robots.begin(), robots.end(), [](const SiteRobot& r) { return !r.many; });
    for (std::size_t t = 0; t < settings.things.size() && watches_things_; ++t) {
        SiteRobot thing;
        thing.shape = settings.things[t];
        thing.size_sigma = settings.things_sigma;
        kind_of_.push_back(bodies_.size());
        bodies_.push_back(body_of(thing));
    }
    candidates_.resize(bodies_.size());
}

const std::vector<BodySighting>& BodyObserver::find(std::span<const SeenBy> cameras, const std::vector<char>& wanted, std::span<const KnownRobot> known,
                                                    const Expectation& expected, const EdgeJudge& edges) {
    found_.clear();
    strange_.clear();
    things_.clear();
    standing_.clear();
    unsure_.clear();
    absent_.clear();
    for (const KnownRobot& robot : known) (robot.sure ? standing_ : unsure_).push_back(robot);
    open_ = wanted;
    const bool any = std::any_of(wanted.begin(), wanted.end(), [](char w) { return w != 0; });
    if (!any && !(watches_things_ && (expected.search || !expected.things.empty()))) return found_;
    expected_.assign(wanted.size(), nullptr);
    for (const PoseObservation& e : expected.robots) {
        const bool well = e.covariance.topLeftCorner<2, 2>().trace() < settings_.expected_within * settings_.expected_within;
        if (well) expected_[static_cast<std::size_t>(e.robot)] = &e;
    }
    known_things_ = expected.things;
    nameless_ = expected.nameless;
    begin_moment(cameras);
    const auto [things_first, kind_in_turn] = turn_of_search(expected.search);
    look_for_things(expected, things_first);
    for (std::size_t kind = 0; kind < kinds(); ++kind) {
        candidates_[kind].clear();
        look_where_expected(kind);
        // Who is missing may stand where another one is expected.
        if (expected.search && (is_missing(kind) || (kind_in_turn == kind && !candidates_[kind].empty()))) search_everywhere(kind);
    }
    while (settle_next(!expected.search, edges)) {
    }
    // Who is still missing: again in what the others leave, where the best places are no longer theirs.
    for (std::size_t kind = 0; kind < kinds() && expected.search; ++kind) {
        if (is_open(kind)) search_everywhere(kind);
    }
    for (std::size_t kind = kinds(); kind < bodies_.size() && expected.search && !things_first; ++kind) search_everywhere(kind);
    while (settle_next(false, edges)) {
    }
    settle_things();
    note_absent();
    return found_;
}

/// What is looked for all over the floor before anything is settled. That costs most, since all that is seen is worth a look then: where no robot is missing,
/// it is things in one search, a kind of robots in another one, lest one be followed that is another thing, and the rest only in what nobody explains.
BodyObserver::SearchTurn BodyObserver::turn_of_search(bool search) {
    if (!search) return {};
    bool missing = false;
    for (std::size_t kind = 0; kind < kinds(); ++kind) missing |= is_missing(kind);
    const long turn = searches_ % settings_.searches_apart;
    const auto round = static_cast<std::size_t>(searches_ / settings_.searches_apart);
    ++searches_;
    SearchTurn result;
    result.things_first = missing || turn == settings_.searches_apart - 1;
    if (turn == 0 && kinds() > 0) result.kind = round % kinds();
    return result;
}

/// Robots of which nothing shows anywhere near where they are expected.
void BodyObserver::note_absent() {
    constexpr double least = 1;  // nats
    for (std::size_t r = 0; r < open_.size(); ++r) {
        if (!open_[r] || !expected_[r]) continue;
        const BodyCandidate likeliest = search_.near(moment_, bodies_[kind_of_[r]], expected_[r]->pose, expected_[r]->covariance, true);
        if (likeliest.score < -least) absent_.push_back({static_cast<int>(r), expected_[r]->pose, likeliest.score});
    }
}

/// What is seen, less what the robots explain that are settled from the start.
void BodyObserver::begin_moment(std::span<const SeenBy> cameras) {
    left_.resize(cameras.size());
    moment_.assign(cameras.begin(), cameras.end());
    for (std::size_t c = 0; c < cameras.size(); ++c) {
        left_[c].copy_pixels(*cameras[c].evidence);
        moment_[c].evidence = &left_[c];
    }
    if (cameras.size() > 1) weigh_shadows(cameras, left_);
    for (Evidence& evidence : left_) evidence.sum_up();
    for (const KnownRobot& robot : standing_) take_away(robot.pose, body(robot.robot));
}

/// Candidates where robots of a kind should be, and where something like them was seen.
void BodyObserver::look_where_expected(std::size_t kind) {
    const auto look_at = [&](const PoseObservation& place) {
        const BodyCandidate found = search_.near(moment_, bodies_[kind], place.pose, place.covariance);
        const bool known = std::any_of(candidates_[kind].begin(), candidates_[kind].end(), [&](const BodyCandidate& c) {
            return std::hypot(c.pose.x - found.pose.x, c.pose.y - found.pose.y) < settings_.search.least_place_sigma;
        });
        if (found.score > 1 && !known) candidates_[kind].push_back(found);
    };
    for (std::size_t r = 0; r < open_.size(); ++r) {
        if (open_[r] && kind_of_[r] == kind && expected_[r]) look_at(*expected_[r]);
    }
    for (const PoseObservation& place : nameless_) {
        if (kind_of_[static_cast<std::size_t>(place.robot)] == kind && is_open(kind)) look_at(place);
    }
    weigh_by_prior(kind);
}

/// Candidates all over the floor, in what nothing explains yet.
void BodyObserver::search_everywhere(std::size_t kind) {
    for (const BodyCandidate& candidate : search_.candidates(moment_, bodies_[kind])) candidates_[kind].push_back(candidate);
    weigh_by_prior(kind);
    auto& candidates = candidates_[kind];
    keep_apart(candidates, candidates.size(), [&](const BodyCandidate& a, const BodyCandidate& b) {
        const double turn = bodies_[kind].round() ? 0 : std::abs(std::remainder(a.pose.yaw - b.pose.yaw, bodies_[kind].symmetry));
        return std::hypot(a.pose.x - b.pose.x, a.pose.y - b.pose.y) < 0.5 * bodies_[kind].radius && turn < 0.5;
    });
}

/// Candidates for what is no robot: where such things were before and, if asked for, everywhere.
void BodyObserver::look_for_things(const Expectation& expected, bool everywhere) {
    for (std::size_t kind = kinds(); kind < bodies_.size(); ++kind) {
        candidates_[kind].clear();
        for (const PoseObservation& thing : expected.things) {
            const BodyCandidate found = search_.near(moment_, bodies_[kind], thing.pose, thing.covariance);
            if (found.score > 1) candidates_[kind].push_back(found);
        }
        if (everywhere) search_everywhere(kind);
    }
}

/// Is it where a thing should be by what was seen of it before?
bool BodyObserver::is_at(const PoseObservation& thing, const Pose2& pose) {
    constexpr double nearby = 9;  // squared Mahalanobis distance
    const Eigen::Vector2d off(pose.x - thing.pose.x, pose.y - thing.pose.y);
    return off.dot(thing.covariance.topLeftCorner<2, 2>().inverse() * off) < nearby;
}

/// Nats by which a thing is likelier to stand at a pose than anywhere on the floor; nothing where none is expected.
std::optional<double> BodyObserver::prior_of_thing(const Pose2& pose) const {
    std::optional<double> most;
    for (const PoseObservation& thing : known_things_) {
        if (is_at(thing, pose)) most = std::max(most.value_or(0), odds_here(thing, pose));
    }
    return most;
}

/// The most that a thing that nobody expects explains of what a robot at a pose leaves.
double BodyObserver::most_of_things(int robot, const Pose2& pose) {
    double most = 0;
    for (std::size_t kind = kinds(); kind < bodies_.size(); ++kind) {
        for (const BodyCandidate& candidate : candidates_[kind]) {
            if (prior_of_thing(candidate.pose) || stand_in_each_other(body(robot), pose, bodies_[kind], candidate.pose)) continue;
            most = std::max(most, search_.score(moment_, bodies_[kind], candidate.pose));
        }
    }
    return most;
}

/// Volume of an upright cylinder about as wide as a body.
static double volume(double radius, double height) { return std::numbers::pi * radius * radius * height; }

/// Nats by which what may be a robot or a thing is likelier to be the robot.
double BodyObserver::odds_against_thing(int robot, std::size_t thing) const {
    const Body& a = body(robot);
    const Body& b = bodies_[thing];
    const double width_a = std::sqrt(a.radius * a.inner_radius), width_b = std::sqrt(b.radius * b.inner_radius);
    const double common = volume(std::min(width_a, width_b), std::min(a.height, b.height));
    const double alike = common / (volume(width_a, a.height) + volume(width_b, b.height) - common);
    return settings_.odds_of_thing + settings_.odds_if_alike * alike * alike;
}

/// Fills `covered_` with the pixels that a body covers in a camera's picture; false where nobody can tell.
bool BodyObserver::list_pixels(const SeenBy& camera, const Body& shape, const Pose2& pose) {
    const Evidence& evidence = *camera.evidence;
    cover(*camera.view, shape.parts, pose, evidence.width, evidence.height, evidence.scale, 1, memory_.mask);
    if (!memory_.mask.valid) return false;
    covered_.clear();
    for_each_pixel(memory_.mask, evidence.width, [&](int pixel) { covered_.push_back(pixel); });
    return true;
}

/// The thing that explains better than a robot at this pose what both would explain, each with the best that the other kind makes of what it leaves;
/// null: the robot does. All samples share the errors of the descriptions, so that only a part of the scores counts.
/// `same_pixels`: things that stand elsewhere on the floor but cover much of the robot's pixels are asked, too: a person's head has its place on the floor
/// far behind the person.
const BodyCandidate* BodyObserver::thing_instead_of(int robot, const Pose2& pose, double score, bool same_pixels) {
    const BodyCandidate* best = nullptr;
    std::size_t best_kind = 0;
    for (std::size_t kind = kinds(); kind < bodies_.size(); ++kind) {
        for (const BodyCandidate& thing : candidates_[kind]) {
            if (best && thing.score <= best->score) continue;
            const double apart = std::hypot(thing.pose.x - pose.x, thing.pose.y - pose.y);
            const bool near = apart <= body(robot).radius + bodies_[kind].radius;
            if (!near && !(same_pixels && covered_part(moment_, body(robot), pose, bodies_[kind], thing.pose, memory_) >= settings_.same_pixels)) continue;
            best = &thing;
            best_kind = kind;
        }
    }
    if (!best) return nullptr;
    const double trust = search_.trust_in(best->score);
    const double prior = std::max(prior_of(robot, pose), 0.0);
    const double colours = std::max(search_.odds_of_look(moment_, body(robot), pose).value_or(0), 0.0);
    // Where a robot is missing, what was seen there before may have been the robot.
    const double before = is_missing_robot(robot) ? 0 : prior_of_thing(best->pose).value_or(0);
    const double lead = trust * (best->score - score) + before - odds_against_thing(robot, best_kind) - prior - colours;
    const double clutter = settings_.search.odds_of_clutter;
    if (lead + std::max(trust * score + prior - clutter, 0.0) <= 0) return nullptr;  // not even if the robot stands elsewhere
    take_away(pose, body(robot), &on_trial_);
    // Who is known by colours is hardly taken for a thing's part: then a thing beside the robot is as likely as one in its place.
    const double rarity = body(robot).has_look() ? odds_against_thing(robot, best_kind) : settings_.rarity_of_things;
    const double thing_behind = trust * most_of_things(robot, pose) - clutter - rarity;
    put_back();
    // One thing may cover what several robots show.
    const double others = explained_beside(robot, best_kind, best->pose, trust) - explained_beside(robot, this->kind(robot), pose, trust);
    return lead - std::max(thing_behind, 0.0) + others > 0 ? best : nullptr;
}

/// Is it open, and expected nowhere?
bool BodyObserver::is_missing_robot(int robot) const { return open_[static_cast<std::size_t>(robot)] && !expected_[static_cast<std::size_t>(robot)]; }

/// May a robot that is missing stand where a thing seems to?
bool BodyObserver::may_be_missing_robot(const Body& thing, const Pose2& pose) const {
    for (std::size_t r = 0; r < open_.size(); ++r) {
        if (!is_missing_robot(static_cast<int>(r))) continue;
        const auto& candidates = candidates_[kind_of_[r]];
        const bool in_its_way = std::any_of(candidates.begin(), candidates.end(),
                                            [&](const BodyCandidate& c) { return stand_in_each_other(bodies_[kind_of_[r]], c.pose, thing, pose); });
        if (in_its_way) return true;
    }
    return false;
}

/// A thing that was seen before, is no robot that is missing and stands there more surely than `least` nats; null: none.
const BodyCandidate* BodyObserver::known_thing(double least) {
    const BodyCandidate* best = nullptr;
    double most = std::max(least, settings_.search.odds_of_clutter);
    for (std::size_t kind = kinds(); kind < bodies_.size(); ++kind) {
        for (const BodyCandidate& thing : candidates_[kind]) {
            const auto prior = prior_of_thing(thing.pose);
            if (!prior || may_be_missing_robot(bodies_[kind], thing.pose)) continue;
            const double odds = search_.odds(moment_, bodies_[kind], thing.pose) + *prior;
            if (odds <= most) continue;
            most = odds;
            best = &thing;
        }
    }
    return best;
}

/// A thing takes its pixels out of what is left, if it is no clutter and stands in no robot. In any case it is no candidate any more.
bool BodyObserver::settle_thing(const BodyCandidate& thing) {
    for (std::size_t kind = kinds(); kind < bodies_.size(); ++kind) {
        auto& candidates = candidates_[kind];
        if (candidates.empty() || &thing < candidates.data() || &thing >= candidates.data() + candidates.size()) continue;
        BodyPlace place = search_.measure(moment_, bodies_[kind], thing);
        const int number = static_cast<int>(robots_ + kind - kinds());
        candidates.erase(candidates.begin() + (&thing - candidates.data()));
        const double rarity = prior_of_thing(place.pose) ? 0 : settings_.rarity_of_things;
        const double odds = place.log_ratio - settings_.search.odds_of_clutter - rarity;
        if (odds < 0 || in_the_way(bodies_[kind], number, place.pose)) return false;
        place.probability = 1 / (1 + std::exp(-odds));
        things_.push_back(place);
        stand(number, place.pose);
        return true;
    }
    return false;
}

/// A thing before robots: they are looked for anew in what it leaves.
void BodyObserver::settle_thing_first(const BodyCandidate& thing) {
    if (!settle_thing(thing)) return;
    for (std::size_t kind = 0; kind < kinds(); ++kind) look_where_expected(kind);
}

/// What no robot explains, the plainest first.
void BodyObserver::settle_things() {
    while (true) {
        const BodyCandidate* best = nullptr;
        for (std::size_t kind = kinds(); kind < bodies_.size(); ++kind) {
            for (const BodyCandidate& thing : candidates_[kind]) {
                if (!best || thing.score > best->score) best = &thing;
            }
        }
        if (!best) return;
        settle_thing(*best);
    }
}

bool BodyObserver::is_open(std::size_t kind) const {
    for (std::size_t r = 0; r < open_.size(); ++r) {
        if (open_[r] && kind_of_[r] == kind) return true;
    }
    return false;
}

/// Is a robot of the kind expected nowhere?
bool BodyObserver::is_missing(std::size_t kind) const {
    for (std::size_t r = 0; r < open_.size(); ++r) {
        if (kind_of_[r] == kind && is_missing_robot(static_cast<int>(r))) return true;
    }
    return false;
}

/// Nats by which a robot is likelier to stand at a pose than anywhere on the floor.
double BodyObserver::prior_of(int robot, const Pose2& pose) const {
    const PoseObservation* expected = expected_[static_cast<std::size_t>(robot)];
    if (!expected) return 0;
    return odds_here(*expected, pose);
}

/// Nats by which what is expected is likelier to stand at a pose than anywhere on the floor.
double BodyObserver::odds_here(const PoseObservation& expected, const Pose2& pose) const {
    constexpr double least = 0.02;  // m: bodies are found no better
    const Eigen::Matrix2d spread = expected.covariance.topLeftCorner<2, 2>() + least * least * Eigen::Matrix2d::Identity();
    const Eigen::Vector2d off(pose.x - expected.pose.x, pose.y - expected.pose.y);
    const double density = std::exp(-0.5 * off.dot(spread.inverse() * off)) / (2 * std::numbers::pi * std::sqrt(spread.determinant()));
    return std::log((1 - settings_.surprise) * density * settings_.floor + settings_.surprise);
}

/// The open robot of a kind that is likeliest to stand at a pose; -1: all of them are settled.
int BodyObserver::likeliest_of(std::size_t kind, const Pose2& pose) const {
    int best = -1;
    for (std::size_t r = 0; r < open_.size(); ++r) {
        if (!open_[r] || kind_of_[r] != kind) continue;
        if (best < 0 || prior_of(static_cast<int>(r), pose) > prior_of(best, pose)) best = static_cast<int>(r);
    }
    return best;
}

void BodyObserver::weigh_by_prior(std::size_t kind) {
    auto& candidates = candidates_[kind];
    search_.weigh(moment_, bodies_[kind], candidates);
    for (BodyCandidate& candidate : candidates) {
        const int robot = likeliest_of(kind, candidate.pose);
        candidate.prior = robot < 0 ? 0 : prior_of(robot, candidate.pose);
    }
    std::sort(candidates.begin(), candidates.end(), [](const BodyCandidate& a, const BodyCandidate& b) { return a.odds + a.prior > b.odds + b.prior; });
}

/// Settles what explains most of what is left, a body or an outline, or leaves it out for good. False: nothing is left to be settled.
/// `only_expected`: outlines of robots that nobody expects anywhere wait until the floor has been searched for their bodies.
bool BodyObserver::settle_next(bool only_expected, const EdgeJudge& edges) {
    std::erase_if(unsure_, [&](const KnownRobot& k) { return !open_[static_cast<std::size_t>(k.robot)] || in_the_way(body(k.robot), k.robot, k.pose); });
    drop_blocked();
    const std::optional<Choice> best = choose();
    double most = best ? best->total : 0;
    auto outline = unsure_.end();
    for (auto u = unsure_.begin(); u != unsure_.end(); ++u) {
        if (only_expected && !expected_[static_cast<std::size_t>(u->robot)]) continue;
        const double odds = odds_of(*u);
        if (odds <= most) continue;
        most = odds;
        outline = u;
    }
    if (const BodyCandidate* thing = known_thing(most)) {
        settle_thing_first(*thing);
        return true;
    }
    if (best && outline == unsure_.end()) {
        outline = rather_than(*best, only_expected);
        if (outline != unsure_.end()) most = score_of(*outline);
    }
    if (outline != unsure_.end()) {
        const KnownRobot likeliest = *outline;
        unsure_.erase(outline);
        const double own = score_of(likeliest) - prior_of(likeliest.robot, likeliest.pose);
        if (const BodyCandidate* thing = thing_instead_of(likeliest.robot, likeliest.pose, own, false)) {
            settle_thing_first(*thing);
            unsure_.push_back(likeliest);
        } else if (most > settings_.search.odds_of_clutter) {
            stand(likeliest.robot, likeliest.pose);
        }
        return true;
    }
    if (!best) return false;
    const std::size_t kind = this->kind(best->robot);
    const BodyCandidate first = candidates_[kind][best->candidate];
    const bool expected_here = prior_of(best->robot, first.pose) > 0;
    if (const BodyCandidate* thing = thing_instead_of(best->robot, first.pose, first.score, !expected_here)) {
        settle_thing_first(*thing);
        return true;
    }
    const auto places = search_.places(moment_, bodies_[kind], rivals_of(*best));
    BodySighting sighting{best->robot, places[0], {places.begin() + 1, places.end()}, {}};
    if (!is_robot(sighting, edges)) {
        candidates_[kind].erase(candidates_[kind].begin() + static_cast<std::ptrdiff_t>(best->candidate));
        // What is no robot at its likeliest place is none farther along the ray either.
        if (!bodies_[kind].has_edges) {
            std::erase_if(candidates_[kind], [&](const BodyCandidate& c) {
                return covered_part(moment_, bodies_[kind], c.pose, bodies_[kind], first.pose, memory_) >= settings_.same_pixels;
            });
        }
        if (bodies_[kind].has_edges && static_cast<int>(strange_.size()) > settings_.most_strange) candidates_[kind].clear();
        return true;
    }
    sighting.kinds = compare_kinds(kind, sighting.place);
    stand(best->robot, sighting.place.pose);
    found_.push_back(std::move(sighting));
    return true;
}

/// By what its body covers and by its edges. What is as large as a robot but has other edges is remembered as strange; edges may show a robot that hardly
/// differs from what it stands before.
bool BodyObserver::is_robot(BodySighting& sighting, const EdgeJudge& edges) {
    double& probability = sighting.place.probability;
    const bool by_area = probability >= settings_.least_probability;
    if (!edges || !body(sighting.robot).has_edges) return by_area;
    const double nats = edges(sighting);
    const double prior = std::max(prior_of(sighting.robot, sighting.place.pose), 0.0);
    if (by_area && nats + sighting.place.body_like + settings_.odds_of_thing + prior >= 0) return true;
    if (!by_area) {
        const double odds = std::log(std::max(probability, 1e-30) / (1 - probability)) + nats;
        probability = 1 / (1 + std::exp(-odds));
        if (probability >= settings_.least_probability) return true;
    }
    strange_.push_back({sighting.robot, sighting.place.pose});
    return false;
}

double BodyObserver::score_of(const KnownRobot& outline, double trust) {
    return trust * search_.score(moment_, body(outline.robot), outline.pose) + outline.edges + prior_of(outline.robot, outline.pose);
}

/// Nats by which an outline's robot stands there, and neither nothing nor a thing of any shape. A body found in its way that explains more is likelier, and
/// all of the difference counts: an outline says that the robot is the very solid that is described.
double BodyObserver::odds_of(const KnownRobot& outline) {
    const Body& shape = body(outline.robot);
    const double score = search_.score(moment_, shape, outline.pose);
    double odds = search_.odds(moment_, shape, outline.pose);
    for (const BodyCandidate& other : candidates_[kind(outline.robot)]) {
        const double apart = std::hypot(other.pose.x - outline.pose.x, other.pose.y - outline.pose.y);
        if (other.score > score && apart < 2 * shape.inner_radius) odds = std::min(odds, other.odds - (other.score - score));
    }
    return odds + outline.edges + prior_of(outline.robot, outline.pose);
}

/// What the open robots and the things that are known explain together of what a body of `kind` at a pose leaves, each robot at a place of its own. The body
/// is that of `robot`, or a thing's: then the robot stands elsewhere, too. One that is expected and has nothing left to stand on is a surprise.
double BodyObserver::explained_beside(int robot, std::size_t kind, const Pose2& pose, double trust) {
    constexpr std::size_t most_candidates = 6;  // of a kind
    const Body& shape = bodies_[kind];
    const bool is_thing = kind >= kinds();
    const double clutter = settings_.search.odds_of_clutter;
    take_away(pose, shape, &on_trial_);
    double all = 0;
    std::vector<Choice> choices;
    for (std::size_t r = 0; r < open_.size(); ++r) {
        const int other = static_cast<int>(r);
        if (!open_[r] || (other == robot && !is_thing)) continue;
        const double nowhere = expected_[r] ? std::log(settings_.surprise) : 0;
        all += nowhere;
        const auto add = [&](const Pose2& there, double nats) {
            if (nats - clutter > nowhere && !stand_in_each_other(shape, pose, body(other), there))
                choices.push_back({other, 0, there, nats - clutter - nowhere});
        };
        for (const KnownRobot& outline : unsure_) {
            if (outline.robot == other) add(outline.pose, score_of(outline, trust));
        }
        const auto& candidates = candidates_[kind_of_[r]];
        for (std::size_t c = 0; c < std::min(candidates.size(), most_candidates); ++c) {
            const Pose2& there = candidates[c].pose;
            add(there, trust * search_.score(moment_, body(other), there) + prior_of(other, there));
        }
        if (other == robot && expected_[r]) {
            const BodyCandidate near = search_.near(moment_, body(other), expected_[r]->pose, expected_[r]->covariance);
            add(near.pose, trust * near.score + prior_of(other, near.pose));
        }
    }
    for (const Choice& choice : likeliest_together(std::move(choices))) all += choice.total;
    for (const PoseObservation& thing : known_things_) {
        if (is_at(thing, pose) && (is_thing || is_missing_robot(robot))) continue;  // it is this one
        double most = std::log(settings_.surprise);
        for (std::size_t other = kinds(); other < bodies_.size(); ++other) {
            for (const BodyCandidate& candidate : candidates_[other]) {
                if (!is_at(thing, candidate.pose) || stand_in_each_other(shape, pose, bodies_[other], candidate.pose)) continue;
                most = std::max(most, trust * search_.score(moment_, bodies_[other], candidate.pose) + odds_here(thing, candidate.pose));
            }
        }
        all += most;
    }
    put_back();
    return all;
}

/// One body may cover what two robots show, one before the other, and explain more than either of them: an outline with which the robots together explain
/// more than with the body in its place. All samples share the errors of the descriptions, so that only a part of the scores counts.
std::vector<KnownRobot>::iterator BodyObserver::rather_than(const Choice& choice, bool only_expected) {
    const BodyCandidate& body_there = candidates_[kind(choice.robot)][choice.candidate];
    const double trust = search_.trust_in(body_there.score);
    auto best = unsure_.end();
    std::optional<double> most;
    for (auto u = unsure_.begin(); u != unsure_.end(); ++u) {
        if (only_expected && !expected_[static_cast<std::size_t>(u->robot)]) continue;
        const bool elsewhere = std::hypot(u->pose.x - body_there.pose.x, u->pose.y - body_there.pose.y) > body(u->robot).inner_radius;
        const bool in_the_way = stand_in_each_other(body(choice.robot), body_there.pose, body(u->robot), u->pose);
        if (u->robot == choice.robot ? !elsewhere : !in_the_way) continue;
        if (!most) {
            most =
                trust * body_there.score + prior_of(choice.robot, body_there.pose) + explained_beside(choice.robot, kind(choice.robot), body_there.pose, trust);
        }
        const double all = score_of(*u, trust) + explained_beside(u->robot, kind(u->robot), u->pose, trust);
        if (all <= *most) continue;
        most = all;
        best = u;
    }
    return best;
}

/// Nats by which one of two candidates of different kinds that stand in each other's way is the likelier one. How much of the pictures they explain favours a
/// small body inside of a large one that has gaps, their shapes one of nearly the same outline that is half empty: the mean of both errs least.
double BodyObserver::likelier_by(const BodyCandidate& a, const BodyCandidate& b) const {
    return 0.5 * (a.odds - b.odds + search_.trust_in(std::max(a.score, b.score)) * (a.score - b.score));
}

/// A candidate's odds where robots of other kinds may stand in its way.
double BodyObserver::odds_among_kinds(std::size_t kind, const BodyCandidate& candidate) const {
    double odds = candidate.odds;
    for (std::size_t other = 0; other < kinds(); ++other) {
        for (const BodyCandidate& c : candidates_[other]) {
            if (other == kind || !stand_in_each_other(bodies_[kind], candidate.pose, bodies_[other], c.pose)) continue;
            if (const double behind = likelier_by(c, candidate); behind > 0) odds = std::min(odds, c.odds - behind);
        }
    }
    return odds;
}

/// Of robots that may stand at places those that together have the highest total, each at a place of its own.
std::vector<BodyObserver::Choice> BodyObserver::likeliest_together(std::vector<Choice> choices) const {
    if (choices.empty()) return choices;
    std::stable_sort(choices.begin(), choices.end(), [](const Choice& a, const Choice& b) { return a.total > b.total; });
    std::vector<std::size_t> places;    // choices that are the best of their places
    std::vector<PossiblePair> pairs;    // of robots and places
    std::vector<std::size_t> of_pairs;  // the choice of each
    const double alone = choices[0].total;
    for (std::size_t i = 0; i < choices.size(); ++i) {
        const auto same = std::find_if(places.begin(), places.end(), [&](std::size_t p) {
            return stand_in_each_other(body(choices[i].robot), choices[i].pose, body(choices[p].robot), choices[p].pose);
        });
        const int column = static_cast<int>(same - places.begin());
        if (same == places.end()) places.push_back(i);
        if (std::any_of(pairs.begin(), pairs.end(), [&](const PossiblePair& p) { return p.row == choices[i].robot && p.column == column; })) continue;
        pairs.push_back({choices[i].robot, column, alone - choices[i].total});
        of_pairs.push_back(i);
    }
    const std::vector<int> column_of = assign(static_cast<int>(open_.size()), static_cast<int>(places.size()), pairs, alone);
    std::vector<Choice> likeliest;
    for (std::size_t k = 0; k < pairs.size(); ++k) {
        if (column_of[static_cast<std::size_t>(pairs[k].row)] == pairs[k].column) likeliest.push_back(choices[of_pairs[k]]);
    }
    return likeliest;
}

/// All open robots at once, so that they explain most together; of these the robot that explains most by itself. One after the other, a robot would take the
/// place of another of nearly its size.
std::optional<BodyObserver::Choice> BodyObserver::choose() const {
    std::vector<Choice> choices;  // of every open robot at every candidate of its kind
    for (std::size_t r = 0; r < open_.size(); ++r) {
        const auto& candidates = candidates_[kind_of_[r]];
        for (std::size_t c = 0; c < candidates.size() && open_[r]; ++c) {
            const double total = odds_among_kinds(kind_of_[r], candidates[c]) + prior_of(static_cast<int>(r), candidates[c].pose);
            if (total > 0) choices.push_back({static_cast<int>(r), c, candidates[c].pose, total});
        }
    }
    const std::vector<Choice> likeliest = likeliest_together(std::move(choices));
    if (likeliest.empty()) return std::nullopt;
    return *std::max_element(likeliest.begin(), likeliest.end(), [](const Choice& a, const Choice& b) { return a.total < b.total; });
}

/// A robot's candidate with those that may be the same robot: the next best places elsewhere are those of its look-alikes.
std::vector<BodyCandidate> BodyObserver::rivals_of(const Choice& choice) const {
    const auto& candidates = candidates_[kind(choice.robot)];
    const BodyCandidate& own = candidates[choice.candidate];
    long others = -1;
    for (std::size_t r = 0; r < open_.size(); ++r) others += open_[r] && kind_of_[r] == kind(choice.robot);
    std::vector<BodyCandidate> rivals;
    const auto add = [&](const BodyCandidate& candidate) {
        rivals.push_back(candidate);
        rivals.back().prior = prior_of(choice.robot, candidate.pose);
        rivals.back().odds = odds_among_kinds(kind(choice.robot), candidate);
    };
    add(own);
    for (std::size_t c = 0; c < candidates.size(); ++c) {
        if (c == choice.candidate) continue;
        const double apart = std::hypot(candidates[c].pose.x - own.pose.x, candidates[c].pose.y - own.pose.y);
        if (apart > 2 * body(choice.robot).inner_radius && others-- > 0) continue;
        add(candidates[c]);
    }
    return rivals;
}

/// How well robots of each kind explain what stands at a place where one of `own` kind was found.
FixedList<double, most_kinds> BodyObserver::compare_kinds(std::size_t own, const BodyPlace& place) {
    constexpr double nearby = 0.1;  // m
    const auto odds_of = [&](std::size_t kind, BodyCandidate candidate) {
        candidate.odds = search_.odds_of_shape(moment_, bodies_[kind], candidate.pose);
        return candidate;
    };
    const BodyCandidate found = odds_of(own, {place.pose, place.log_ratio});
    FixedList<double, most_kinds> nats;
    for (std::size_t kind = 0; kind < std::min(kinds(), most_kinds); ++kind) {
        if (kind == own) {
            nats.push_back(0);
            continue;
        }
        const BodyCandidate other = search_.near(moment_, bodies_[kind], place.pose, nearby * nearby * Eigen::Matrix3d::Identity(), true);
        nats.push_back(likelier_by(odds_of(kind, other), found));
    }
    return nats;
}

/// A robot is settled: what it covers explains the other candidates less.
void BodyObserver::stand(int robot, const Pose2& pose) {
    if (static_cast<std::size_t>(robot) < robots_) open_[static_cast<std::size_t>(robot)] = 0;
    standing_.push_back({robot, pose});
    take_away(pose, body(robot));
    for (std::size_t kind = 0; kind < bodies_.size(); ++kind) {
        if (kind < kinds() && !is_open(kind)) {
            candidates_[kind].clear();
            continue;
        }
        search_.score_again(moment_, bodies_[kind], candidates_[kind]);
        weigh_by_prior(kind);
    }
}

/// Would a robot at this pose stand in another one that is settled?
bool BodyObserver::in_the_way(const Body& shape, int robot, const Pose2& pose) const {
    return std::any_of(standing_.begin(), standing_.end(), [&](const KnownRobot& other) {
        return (other.robot != robot || static_cast<std::size_t>(robot) >= robots_) && stand_in_each_other(shape, pose, body(other.robot), other.pose);
    });
}

bool BodyObserver::stand_in_each_other(const Body& a, const Pose2& at_a, const Body& b, const Pose2& at_b) const {
    return std::hypot(at_a.x - at_b.x, at_a.y - at_b.y) < settings_.overlap * (a.inner_radius + b.inner_radius);
}

void BodyObserver::drop_blocked() {
    for (std::size_t kind = 0; kind < bodies_.size(); ++kind) {
        std::erase_if(candidates_[kind], [&](const BodyCandidate& c) {
            const bool strange = std::any_of(strange_.begin(), strange_.end(), [&](const KnownRobot& s) {
                return this->kind(s.robot) == kind && stand_in_each_other(bodies_[kind], c.pose, bodies_[kind], s.pose);
            });
            return strange || in_the_way(bodies_[kind], -1, c.pose);
        });
    }
}

bool BodyObserver::holds(const KnownRobot& known) const {
    return std::any_of(standing_.begin(), standing_.end(), [&](const KnownRobot& s) {
        return s.robot == known.robot && std::hypot(s.pose.x - known.pose.x, s.pose.y - known.pose.y) < body(known.robot).radius;
    });
}

KnownRobot known_by_outline(const SilhouetteObservation& outline) { return {outline.robot, outline.pose, !outline.doubtful, outline.edges}; }

bool BodyObserver::wants_colours() const {
    return std::any_of(bodies_.begin(), bodies_.end(), [](const Body& body) { return body.has_look(); });
}

/// What other outlines cover, beside the pixels that are `covered_`, is no shadow of this body: it is set aside.
void BodyObserver::spare_outlines(std::size_t camera, const Pose2& pose, const Body& shape) {
    Evidence& evidence = left_[camera];
    spared_.clear();
    if (unsure_.empty()) return;
    std::sort(covered_.begin(), covered_.end());
    for (const KnownRobot& outline : unsure_) {
        if (stand_in_each_other(shape, pose, body(outline.robot), outline.pose)) continue;
        cover(*moment_[camera].view, body(outline.robot).parts, outline.pose, evidence.width, evidence.height, evidence.scale, 1, memory_.mask);
        if (!memory_.mask.valid) continue;
        for_each_pixel(memory_.mask, evidence.width, [&](int number) {
            const auto pixel = static_cast<std::size_t>(number);
            if (evidence.perhaps[pixel] <= 0 || std::binary_search(covered_.begin(), covered_.end(), number)) return;
            spared_.emplace_back(pixel, evidence.perhaps[pixel]);
            evidence.perhaps[pixel] = 0;
        });
    }
}

/// What a body covers says nothing about others: neither that they are there, nor that they are not. `before`: of each camera, what put_back() needs.
void BodyObserver::take_away(const Pose2& pose, const Body& body, std::vector<std::vector<Evidence::Change>>* before) {
    if (before) before->resize(moment_.size());
    for (std::size_t c = 0; c < moment_.size(); ++c) {
        Evidence& evidence = left_[c];
        if (before) (*before)[c].clear();
        if (!list_pixels(moment_[c], body, pose)) continue;
        spare_outlines(c, pose, body);
        evidence.take_away(covered_, before ? &(*before)[c] : nullptr);
        for (const auto& [pixel, shadow] : spared_) evidence.perhaps[pixel] = shadow;
    }
}

void BodyObserver::put_back() {
    for (std::size_t c = 0; c < moment_.size(); ++c) left_[c].put_back(on_trial_[c]);
}

bool BodyObserver::confirms(const SeenBy& camera, int robot, const Pose2& pose) {
    const PlaceScore score = score_place(camera, body(robot), pose, settings_.search.score, memory_);
    return score.in_picture && score.filled > settings_.plainly_filled && score.around < settings_.plainly_alone &&
           score.log_ratio > settings_.search.odds_of_clutter;
}

bool BodyObserver::shows(const SeenBy& camera, int robot, const Pose2& pose) {
    const PlaceScore score = score_place(camera, body(robot), pose, settings_.search.score, memory_);
    return score.in_picture && score.log_ratio > settings_.search.odds_of_clutter;
}

bool BodyObserver::agrees(std::span<const SeenBy> cameras, int robot, const Pose2& pose, const BodyPlace& best) {
    return search_.score(cameras, body(robot), pose) > search_.score(cameras, body(robot), best.pose) - settings_.outline_loss;
}

}  // namespace roomfix
