#include "roomfix/overhead/body_observer.hpp"

#include <algorithm>

namespace roomfix {

BodyObserver::BodyObserver(const std::vector<SiteRobot>& robots, const BodyObserverSettings& settings) : settings_(settings), search_(settings.search) {
    for (const SiteRobot& robot : robots) {
        bodies_.push_back(body_of(robot));
        countable_.push_back(!robot.many);
    }
}

const std::vector<BodySighting>& BodyObserver::find(std::span<const SeenBy> cameras, const std::vector<char>& wanted) {
    found_.clear();
    std::vector<char> open = wanted.empty() ? countable_ : wanted;
    left_.resize(cameras.size());
    moment_.assign(cameras.begin(), cameras.end());
    for (std::size_t c = 0; c < cameras.size(); ++c) {
        left_[c] = *cameras[c].evidence;
        moment_[c].evidence = &left_[c];
    }
    for (;;) {
        BodySighting best;
        best.robot = -1;
        for (std::size_t r = 0; r < bodies_.size(); ++r) {
            if (!open[r] || !countable_[r]) continue;
            auto places = search_.find(moment_, bodies_[r]);
            if (places.empty() || places[0].probability < settings_.least_probability) {
                open[r] = 0;  // with less evidence left it will not be found either
                continue;
            }
            if (best.robot >= 0 && places[0].log_ratio <= best.place.log_ratio) continue;
            best.robot = static_cast<int>(r);
            best.place = places[0];
            best.others.assign(places.begin() + 1, places.end());
        }
        if (best.robot < 0) return found_;
        open[static_cast<std::size_t>(best.robot)] = 0;
        take_away(best.place, bodies_[static_cast<std::size_t>(best.robot)]);
        found_.push_back(std::move(best));
        if (std::none_of(open.begin(), open.end(), [](char o) { return o != 0; })) return found_;
    }
}

/// What a body explains says nothing about others: as if nothing differed there.
void BodyObserver::take_away(const BodyPlace& place, const Body& body) {
    for (std::size_t c = 0; c < moment_.size(); ++c) {
        Evidence& evidence = left_[c];
        cover(*moment_[c].view, body.parts, place.pose, evidence.width, evidence.height, evidence.scale, 1, mask_);
        if (!mask_.valid) continue;
        for (const Span& span : mask_.spans) {
            Evidence::Sums* row = evidence.pixels.data() + static_cast<std::ptrdiff_t>(span.y) * evidence.width;
            std::fill(row + span.begin, row + span.end, Evidence::Sums{0, 1});
        }
        evidence.sum_up();
    }
}

bool BodyObserver::confirms(const SeenBy& camera, int robot, const Pose2& pose) {
    const PlaceScore score = score_place(*camera.view, *camera.evidence, body(robot), pose, settings_.search.score, mask_);
    return score.in_picture && score.filled > settings_.plainly_filled && score.around < settings_.plainly_alone &&
           score.log_ratio > settings_.search.odds_of_clutter;
}

bool BodyObserver::agrees(std::span<const SeenBy> cameras, int robot, const Pose2& pose, const BodyPlace& best) {
    return search_.score(cameras, body(robot), pose) > search_.score(cameras, body(robot), best.pose) - settings_.outline_loss;
}

}  // namespace roomfix
