#include "roomfix/overhead/body_observer.hpp"

#include <algorithm>

namespace roomfix {

BodyObserver::BodyObserver(const std::vector<SiteRobot>& robots, const BodyObserverSettings& settings) : settings_(settings), search_(settings.search) {
    for (std::size_t r = 0; r < robots.size(); ++r) {
        const auto alike =
            std::find_if(robots.begin(), robots.begin() + static_cast<std::ptrdiff_t>(r), [&](const SiteRobot& other) { return look_alike(other, robots[r]); });
        if (alike != robots.begin() + static_cast<std::ptrdiff_t>(r)) {
            kind_of_.push_back(kind_of_[static_cast<std::size_t>(alike - robots.begin())]);
        } else {
            kind_of_.push_back(bodies_.size());
            bodies_.push_back(body_of(robots[r]));
        }
    }
    candidates_.resize(bodies_.size());
}

const std::vector<BodySighting>& BodyObserver::find(std::span<const SeenBy> cameras, const std::vector<char>& wanted, std::span<const KnownRobot> known) {
    found_.clear();
    if (std::none_of(wanted.begin(), wanted.end(), [](char w) { return w != 0; })) return found_;
    left_.resize(cameras.size());
    moment_.assign(cameras.begin(), cameras.end());
    for (std::size_t c = 0; c < cameras.size(); ++c) {
        left_[c] = *cameras[c].evidence;
        moment_[c].evidence = &left_[c];
    }
    for (const KnownRobot& robot : known) take_away(robot.pose, body(robot.robot));
    std::vector<char> open = wanted;
    for (std::size_t kind = 0; kind < bodies_.size(); ++kind) {
        candidates_[kind].clear();
        for (std::size_t r = 0; r < open.size(); ++r) {
            if (!open[r] || kind_of_[r] != kind) continue;
            candidates_[kind] = search_.candidates(moment_, bodies_[kind]);
            break;
        }
    }
    for (;;) {
        // The robot that explains most of what is left.
        int best = -1;
        for (std::size_t r = 0; r < open.size(); ++r) {
            if (!open[r] || candidates_[kind_of_[r]].empty()) continue;
            if (best < 0 || candidates_[kind_of_[r]][0].score > candidates_[kind_of_[static_cast<std::size_t>(best)]][0].score) best = static_cast<int>(r);
        }
        if (best < 0) return found_;
        const Body& shape = body(best);
        auto& candidates = candidates_[kind_of_[static_cast<std::size_t>(best)]];
        auto places = search_.places(moment_, shape, candidates);
        if (places.empty() || places[0].probability < settings_.least_probability) {
            candidates.clear();
            continue;
        }
        open[static_cast<std::size_t>(best)] = 0;
        take_away(places[0].pose, shape);
        BodySighting sighting{best, places[0], {}};
        sighting.others.assign(places.begin() + 1, places.end());
        found_.push_back(std::move(sighting));
        // What is left explains the other candidates less.
        for (std::size_t kind = 0; kind < bodies_.size(); ++kind) search_.score_again(moment_, bodies_[kind], candidates_[kind]);
    }
}

bool BodyObserver::wants_colours() const {
    return std::any_of(bodies_.begin(), bodies_.end(), [](const Body& body) { return body.has_look(); });
}

/// What a body explains says nothing about others: as if it was the background.
void BodyObserver::take_away(const Pose2& pose, const Body& body) {
    for (std::size_t c = 0; c < moment_.size(); ++c) {
        Evidence& evidence = left_[c];
        cover(*moment_[c].view, body.parts, pose, evidence.width, evidence.height, evidence.scale, 1, memory_.mask);
        if (!memory_.mask.valid || memory_.mask.spans.empty()) continue;
        for (const Span& span : memory_.mask.spans) {
            Evidence::Sums* row = evidence.pixels.data() + static_cast<std::ptrdiff_t>(span.y) * evidence.width;
            std::fill(row + span.begin, row + span.end, Evidence::Sums{0, 1});
        }
        evidence.sum_up();
    }
}

bool BodyObserver::confirms(const SeenBy& camera, int robot, const Pose2& pose) {
    const PlaceScore score = score_place(*camera.view, *camera.evidence, body(robot), pose, settings_.search.score, memory_);
    return score.in_picture && score.filled > settings_.plainly_filled && score.around < settings_.plainly_alone &&
           score.log_ratio > settings_.search.odds_of_clutter;
}

bool BodyObserver::is_no_exact_solid(const SeenBy& camera, int robot, const Pose2& pose, double support) {
    if (support >= settings_.exact_support) return false;
    const PlaceScore score = score_place(*camera.view, *camera.evidence, body(robot), pose, settings_.search.score, memory_);
    return score.in_picture && score.filled > settings_.plainly_shown && score.log_ratio > settings_.search.odds_of_clutter;
}

bool BodyObserver::agrees(std::span<const SeenBy> cameras, int robot, const Pose2& pose, const BodyPlace& best) {
    return search_.score(cameras, body(robot), pose) > search_.score(cameras, body(robot), best.pose) - settings_.outline_loss;
}

}  // namespace roomfix
