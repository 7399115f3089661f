#include "roomfix/estimate/start_cloud.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "roomfix/base/decompositions.hpp"
#include "roomfix/base/random_vector.hpp"

namespace roomfix {
namespace {

constexpr std::size_t first_guesses = 20000;  // until it is clear which of them matter
constexpr std::size_t guess_count = 4000;
constexpr double largest_error = 60;    // times what is stated
constexpr double bearing_error = 3;     // times what is stated
constexpr double misread = 0.05;        // part of what is seen that is something else
constexpr double anywhere = 20;         // m, over which that is
constexpr double straight_ahead = 0.4;  // cosine of the widest direction in which depths are measured
constexpr double depths = 0.2;          // probability that ranges are depths where the front matters

// Of wheels of which nobody knows how they err.
constexpr double way_error = 0.05, way_part = 0.03;                           // per root of a metre, of a metre
constexpr double turn_error = 0.15, turn_per_way = 0.05, turn_still = 0.005;  // per root of a radian, of a metre, of a second
constexpr double scale_error = 0.1;                                           // of way and turning, throughout
// Of a robot of which nobody knows how it moves, per root of a second.
constexpr double walk = 0.3, walk_turn = 0.5;

// What one source says again says something new after such a way, turning, or time.
constexpr double new_way = 0.1, new_turning = 0.3;
constexpr double new_time = 0.5, new_time_on_wheels = 5;

constexpr int least_used = 6;
constexpr double near = 0.25;  // m: a place known that well is known well enough ...
constexpr double bent = 0.12;  // ... or to that part of the distance to what was heard
constexpr double front_known = widest_front;
constexpr std::size_t most_places = 4;
constexpr double least_share = 0.1;  // of a place that is not to be forgotten
constexpr double enough = 0.75;      // of all that the places together must make up

/// Receiver and beacon, or landmark.
std::pair<int, int> source_of(const Heard& heard) {
    if (const auto* range = std::get_if<RangeObservation>(&heard)) return {range->receiver, range->beacon};
    if (const auto* difference = std::get_if<RangeDifferenceObservation>(&heard)) {
        return {difference->receiver, 1000 * (1 + difference->beacons[0]) + difference->beacons[1]};
    }
    return {-1, std::get<SightingObservation>(heard).landmark};
}

const Eigen::Vector3d& beacon_of(const TrackingModels& models, int number) { return models.site.beacons[static_cast<std::size_t>(number)].position; }

double stated_error(const Heard& heard) {
    if (const auto* range = std::get_if<RangeObservation>(&heard)) return range->sigma;
    if (const auto* difference = std::get_if<RangeDifferenceObservation>(&heard)) return difference->sigma;
    return std::get<SightingObservation>(heard).range_sigma;
}

/// Density of an error, by Student's t distribution with four degrees of freedom: its tails are heavy, and it needs no power but a root.
double student(double error, double sigma) {
    const double t = 1 + error * error / (4 * sigma * sigma);
    return 0.375 / (sigma * t * t * std::sqrt(t));
}

Eigen::Vector3d receiver_at(const Pose2& robot, const RangeSource& receiver, bool front) {
    Eigen::Vector3d place(robot.x, robot.y, receiver.receiver.z());
    if (front && !receiver.receiver.head<2>().isZero(0)) place.head<2>() += Eigen::Rotation2Dd(robot.yaw) * receiver.receiver.head<2>();
    return place;
}

/// What may have been heard: places in the map, m.
std::vector<Eigen::Vector2d> heard_from(const Heard& heard, const TrackingModels& models) {
    std::vector<Eigen::Vector2d> places;
    if (const auto* range = std::get_if<RangeObservation>(&heard)) {
        places.push_back(beacon_of(models, range->beacon).head<2>());
    } else if (const auto* difference = std::get_if<RangeDifferenceObservation>(&heard)) {
        for (const int beacon : difference->beacons) places.push_back(beacon_of(models, beacon).head<2>());
    } else {
        const auto& sighting = std::get<SightingObservation>(heard);
        for (std::size_t i = 0; i < models.marks.size(); ++i) {
            const bool named = sighting.landmark == static_cast<int>(i);
            if (named || (sighting.landmark < 0 && models.marks[i].plain)) places.push_back(models.marks[i].place);
        }
    }
    return places;
}

}  // namespace

std::vector<PlaceProposal> places_around(const Heard& heard, bool depth, const TrackingModels& models) {
    constexpr int directions = 24, fronts = 8;
    constexpr double range_doubt = 0.07, least_doubt = 0.1;  // of a range that nobody vouches for: a part of it, m
    constexpr double bearing_doubt = 0.03;                   // rad
    constexpr double step = 2 * std::numbers::pi / directions, front_step = 2 * std::numbers::pi / fronts;
    std::optional<double> range, bearing;
    if (const auto* stated = std::get_if<RangeObservation>(&heard)) range = stated->range;
    if (const auto* sighting = std::get_if<SightingObservation>(&heard)) {
        range = sighting->range;
        bearing = sighting->bearing;
    }
    if (!range) return {};
    const double distance = *range / (depth && bearing ? std::max(std::cos(*bearing), straight_ahead) : 1);
    const double radial = range_doubt * distance + least_doubt;
    std::vector<PlaceProposal> places;
    for (const Eigen::Vector2d& mark : heard_from(heard, models)) {
        for (int i = 0; i < directions; ++i) {
            const double direction = i * step;
            const Eigen::Vector3d outward(std::cos(direction), std::sin(direction), 0);
            // Half a step farther along the circle, where it sees the same in another direction: its front turns with it.
            const Eigen::Vector3d along = 0.5 * step * Eigen::Vector3d(-distance * outward.y(), distance * outward.x(), bearing ? 1 : 0);
            PlaceProposal place{{mark.x() + distance * outward.x(), mark.y() + distance * outward.y(), 0},
                                radial * radial * outward * outward.transpose() + along * along.transpose()};
            place.covariance.diagonal() += Eigen::Vector3d(1e-4, 1e-4, std::pow(bearing ? bearing_doubt : 0.5 * front_step, 2));
            for (int k = 0; k < (bearing ? 1 : fronts); ++k) {
                place.pose.yaw = wrap_angle(bearing ? direction + std::numbers::pi - *bearing : k * front_step);
                places.push_back(place);
            }
        }
    }
    return places;
}

double widest_place(double distance) { return std::max(near, bent * distance); }

Nanoseconds time_of(const Heard& heard) {
    return std::visit([](const auto& h) { return h.time; }, heard);
}

void StartCloud::take(const Heard& heard, int robot, const TrackingModels& models) {
    look(robot, heard, models);
    if (guesses_.empty()) return begin(heard, models);
    move(time_of(heard), models);
    if (!tells_something(heard)) return;
    ++used_;
    weigh(heard, models);
}

void StartCloud::look(int robot, const Heard& heard, const TrackingModels& models) {
    robot_ = robot;
    const auto* sighting = std::get_if<SightingObservation>(&heard);
    sees_ |= sighting != nullptr && sighting->bearing.has_value();
    const bool drives = !models.driven[static_cast<std::size_t>(robot)].empty();
    const bool several = models.receivers[static_cast<std::size_t>(robot)].size() > 1;
    shows_front_ = sees_ || drives || several;
    front_by_way_ = drives && !sees_ && !several;
}

void StartCloud::guess_errors() {
    for (Guess& guess : guesses_) guess.depth = depth_.value_or(shows_front_ && random_.uniform() < depths);
    if (wheels_.learned) return;
    for (Guess& guess : guesses_) {
        guess.scale = scale_error * random_.normal();
        guess.turn_scale = scale_error * random_.normal();
    }
}

/// All around what was heard first.
void StartCloud::begin(const Heard& heard, const TrackingModels& models) {
    begun_ = time_ = time_of(heard);
    used_ = 1;
    (void)tells_something(heard);
    guesses_.resize(first_guesses);
    const std::vector<Eigen::Vector2d> around = heard_from(heard, models);
    double radius = 3;
    if (const auto* range = std::get_if<RangeObservation>(&heard)) radius = range->range;
    if (std::holds_alternative<RangeDifferenceObservation>(heard)) radius = (around[0] - around[1]).norm();
    if (const auto* seen = std::get_if<SightingObservation>(&heard)) radius = seen->range.value_or(radius);
    distance_ = radius;
    const bool anywhere_within =
        std::holds_alternative<RangeDifferenceObservation>(heard) || !std::visit(
                                                                         [](const auto& h) {
                                                                             if constexpr (std::is_same_v<std::decay_t<decltype(h)>, SightingObservation>)
                                                                                 return h.range.has_value();
                                                                             return true;
                                                                         },
                                                                         heard);
    for (Guess& guess : guesses_) {
        const double error = stated_error(heard) * std::pow(largest_error, random_.uniform());
        const auto which = std::min(static_cast<std::size_t>(random_.uniform() * static_cast<double>(around.size())), around.size() - 1);
        const double far = anywhere_within ? 2 * radius * std::sqrt(random_.uniform()) : std::max(radius + 1.5 * error * random_.normal(), 0.0);
        const double direction = 2 * std::numbers::pi * random_.uniform();
        const Eigen::Vector2d place = around[which] + far * Eigen::Vector2d(std::cos(direction), std::sin(direction));
        guess.x = place.x();
        guess.y = place.y();
        guess.yaw = 2 * std::numbers::pi * random_.uniform();
        guess.log_error = std::log(error);
        const auto* sighting = std::get_if<SightingObservation>(&heard);
        if (sighting != nullptr && sighting->bearing) {
            guess.yaw = direction + std::numbers::pi - *sighting->bearing + bearing_error * sighting->bearing_sigma * random_.normal();
        }
    }
    guess_errors();
}

/// As the wheels say, or at random; up to the wheels' last word if what was heard is newer.
void StartCloud::move(Nanoseconds time, const TrackingModels& models) {
    if (time <= time_) return;
    const OdometryTrack& driven = models.driven[static_cast<std::size_t>(robot_)];
    const Nanoseconds delay = from_seconds(wheels_.delay);
    Nanoseconds to = time;
    if (!driven.empty() && driven.newest_time() + delay > time_) to = std::min(time, driven.newest_time() + delay);
    const auto step = driven.step(time_ - delay, to - delay);
    const double seconds = to_seconds((step ? to : time) - time_);
    time_ = step ? to : time;
    if (step) {
        const double way = step->way.norm(), turned = std::abs(step->turned);
        way_ += way;
        turning_ += turned;
        const double along = way_error * std::sqrt(way) + way_part * way;
        const double turn = turn_error * std::sqrt(turned) + turn_per_way * std::sqrt(way) + turn_still * std::sqrt(seconds);
        for (Guess& guess : guesses_) {
            const double missing = (wheels_.turn_scale + guess.turn_scale) * step->turned + wheels_.drift * seconds;
            const Eigen::Vector2d moved =
                Eigen::Rotation2Dd(guess.yaw + 0.5 * missing) * ((1 + wheels_.scale + guess.scale) * step->way + along * normal2(random_));
            guess.x += moved.x();
            guess.y += moved.y();
            guess.yaw += step->turned + missing + turn * random_.normal();
        }
        return;
    }
    const double root = std::sqrt(seconds);
    for (Guess& guess : guesses_) {
        guess.x += walk * root * random_.normal();
        guess.y += walk * root * random_.normal();
        guess.yaw += walk_turn * root * random_.normal();
    }
}

bool StartCloud::tells_something(const Heard& heard) {
    const auto [known, fresh] = last_.try_emplace(source_of(heard), LastWord{way_, turning_, time_of(heard)});
    if (fresh) return true;
    LastWord& last = known->second;
    const double seconds = to_seconds(time_of(heard) - last.time);
    const bool moved = way_ - last.way > new_way || turning_ - last.turning > new_turning;
    const bool waited = seconds > (way_ > 0 ? new_time_on_wheels : new_time);
    // Without a name nobody knows whether it is the same landmark again.
    if (!moved && !waited && known->first.second >= 0) return false;
    last = {way_, turning_, time_of(heard)};
    return true;
}

void StartCloud::weigh(const Heard& heard, const TrackingModels& models) {
    // Nothing where it cannot be measured at all: what measures depths does not see far to the side.
    Eigen::Vector2d front = Eigen::Vector2d::UnitX();  // of the guess, where it measures depths
    const auto stated = [&front](const Guess& guess, double range, const Eigen::Vector2d& way) -> std::optional<double> {
        if (!guess.depth) return range;
        const double ahead = front.x() * way.x() + front.y() * way.y();
        if (ahead < straight_ahead * way.norm()) return std::nullopt;
        return range * ahead / std::max(way.norm(), 1e-6);
    };
    const auto density_of = [&](double measured, const std::optional<double>& expected, double sigma) {
        return expected ? student(measured - *expected, sigma) : 0.01 * misread / anywhere;
    };
    const auto likelihood = [&](const Guess& guess) {
        const Pose2 robot{guess.x, guess.y, guess.yaw};
        const double sigma = std::exp(guess.log_error);
        if (guess.depth) front = {std::cos(guess.yaw), std::sin(guess.yaw)};
        if (const auto* range = std::get_if<RangeObservation>(&heard)) {
            const Eigen::Vector3d place = receiver_at(robot, models.receiver(robot_, range->receiver), shows_front_);
            const Eigen::Vector3d way = beacon_of(models, range->beacon) - place;
            return density_of(range->range, stated(guess, way.norm(), way.head<2>()), sigma);
        }
        if (const auto* difference = std::get_if<RangeDifferenceObservation>(&heard)) {
            const Eigen::Vector3d place = receiver_at(robot, models.receiver(robot_, difference->receiver), shows_front_);
            const double exact = (place - beacon_of(models, difference->beacons[1])).norm() - (place - beacon_of(models, difference->beacons[0])).norm();
            return student(difference->difference - exact, sigma);
        }
        const auto& seen = std::get<SightingObservation>(heard);
        const double nothing = (seen.range ? 1 / anywhere : 1) * (seen.bearing ? 1 / (2 * std::numbers::pi) : 1);
        const auto of = [&](int landmark) {
            const Eigen::Vector2d& mark = models.marks[static_cast<std::size_t>(landmark)].place;
            // What predict_sighting() predicts, without the derivatives that it computes along: this is asked for each guess and landmark.
            const Eigen::Vector2d way = mark - Eigen::Vector2d(guess.x, guess.y);
            const double density = seen.range ? density_of(*seen.range, stated(guess, std::max(way.norm(), 0.01), way), sigma) : 1;
            if (!seen.bearing) return density;
            const double expected = wrap_angle(std::atan2(way.y(), way.x()) - guess.yaw);
            return density * student(wrap_angle(*seen.bearing - expected), bearing_error * seen.bearing_sigma);
        };
        if (seen.landmark >= 0) return (1 - misread) * of(seen.landmark) + misread * nothing;
        double sum = 0, count = 0;
        for (std::size_t i = 0; i < models.marks.size(); ++i) {
            if (!models.marks[i].plain) continue;
            sum += of(static_cast<int>(i));
            ++count;
        }
        return (1 - misread) * sum / std::max(count, 1.0) + misread * nothing;
    };
    if (const auto* range = std::get_if<RangeObservation>(&heard)) distance_ += 0.2 * (range->range - distance_);
    if (const auto* seen = std::get_if<SightingObservation>(&heard); seen != nullptr && seen->range) distance_ += 0.2 * (*seen->range - distance_);
    double most = -1e300;
    for (Guess& guess : guesses_) {
        guess.log_weight += std::log(likelihood(guess) + 1e-30);
        most = std::max(most, guess.log_weight);
    }
    double sum = 0, squares = 0;
    for (Guess& guess : guesses_) {
        guess.log_weight -= most;
        const double w = std::exp(guess.log_weight);
        sum += w;
        squares += w * w;
    }
    if (sum * sum / squares < 0.5 * static_cast<double>(guesses_.size())) draw_again();
}

/// How far the fronts of guesses are drawn apart, rad. Where only the way tells the front, a short way tells little of it: few guesses survive the first
/// ranges, and their fronts must not be taken for all that are possible.
double StartCloud::turned_apart(double error) const {
    constexpr double least = 0.03, most = 1.5;
    return front_by_way_ ? std::clamp(0.3 * error / std::max(way_, 1e-3), least, most) : least;
}

/// Guesses by their weights, each then a little apart from its like.
void StartCloud::draw_again() {
    double sum = 0;
    for (const Guess& guess : guesses_) sum += std::exp(guess.log_weight);
    const std::size_t count = used_ < 2 * least_used ? guesses_.size() : guess_count;
    const double step = sum / static_cast<double>(count);
    std::vector<Guess> drawn;
    drawn.reserve(count);
    double next = step * random_.uniform(), passed = 0;
    for (const Guess& guess : guesses_) {
        passed += std::exp(guess.log_weight);
        for (; next < passed && drawn.size() < count; next += step) drawn.push_back(guess);
    }
    while (drawn.size() < count) drawn.push_back(drawn.back());
    for (Guess& guess : drawn) {
        const double error = std::exp(guess.log_error);
        const double apart = 0.2 * error;
        guess.x += apart * random_.normal();
        guess.y += apart * random_.normal();
        guess.yaw += turned_apart(error) * random_.normal();
        guess.log_error += 0.05 * random_.normal();
        if (!wheels_.learned) {
            guess.scale += 0.05 * scale_error * random_.normal();
            guess.turn_scale += 0.05 * scale_error * random_.normal();
        }
        guess.log_weight = 0;
    }
    guesses_ = std::move(drawn);
}

void StartCloud::mark() {
    for (Guess& guess : guesses_) guess.marked = {guess.x, guess.y, guess.yaw};
}

std::vector<PlaceProposal> StartCloud::marked() const {
    constexpr std::size_t most = 2;
    // Guesses with the same past count as one.
    std::map<std::array<double, 3>, double> pasts;
    double all = 0;
    for (const Guess& guess : guesses_) {
        const double weight = std::exp(guess.log_weight);
        pasts[{guess.marked.x, guess.marked.y, guess.marked.yaw}] += weight;
        all += weight;
    }
    const double reach = 0.5 * widest_place(distance_);
    std::vector<PlaceProposal> places;
    while (!pasts.empty() && places.size() < most) {
        const auto heaviest = std::max_element(pasts.begin(), pasts.end(), [](const auto& a, const auto& b) { return a.second < b.second; })->first;
        PlaceProposal place{{heaviest[0], heaviest[1], heaviest[2]},
                            Eigen::Vector3d(reach * reach, reach * reach, 0.25 * front_known * front_known).asDiagonal()};
        place.weight = 0;
        for (auto past = pasts.begin(); past != pasts.end();) {
            const auto& at = past->first;
            const bool near_it =
                std::hypot(at[0] - heaviest[0], at[1] - heaviest[1]) < 2 * reach && std::abs(wrap_angle(at[2] - heaviest[2])) < 2 * front_known;
            place.weight += near_it ? past->second / all : 0;
            past = near_it ? pasts.erase(past) : std::next(past);
        }
        if (place.weight < least_share) break;
        places.push_back(place);
    }
    return places;
}

StartPlaces StartCloud::places(double patience) const {
    StartPlaces result;
    if (used_ < least_used) {
        result.reason = fmt::format("only {} ranges or sightings told something new", used_);
        return result;
    }
    const double waited = to_seconds(time_ - begun_);
    const double reach = widest_place(distance_);
    std::vector<double> left;             // weights of the guesses that belong to no place yet
    std::vector<Eigen::Vector2d> fronts;  // where they look
    left.reserve(guesses_.size());
    fronts.reserve(guesses_.size());
    double all = 0, by_depth = 0;
    for (const Guess& guess : guesses_) {
        left.push_back(std::exp(guess.log_weight));
        fronts.emplace_back(std::cos(guess.yaw), std::sin(guess.yaw));
        all += left.back();
        by_depth += guess.depth ? left.back() : 0;
    }
    double taken = 0;
    result.depth = by_depth > 0.5 * all;
    for (std::size_t k = 0; k < most_places; ++k) {
        // Around the heaviest guess, then around the mean of what is near that, once more.
        const auto heaviest = static_cast<std::size_t>(std::max_element(left.begin(), left.end()) - left.begin());
        Eigen::Vector2d middle(guesses_[heaviest].x, guesses_[heaviest].y);
        Eigen::Vector2d front = fronts[heaviest];
        Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
        double weight = 0, error = 0, yaw = 0;
        const auto belongs = [&](std::size_t i) {
            if (left[i] <= 0 || (Eigen::Vector2d(guesses_[i].x, guesses_[i].y) - middle).norm() > 3 * reach) return false;
            return !shows_front_ || fronts[i].dot(front) > 0.5;
        };
        for (int round = 0; round < 3; ++round) {
            Eigen::Vector2d sum = Eigen::Vector2d::Zero(), fronts_sum = Eigen::Vector2d::Zero();
            weight = error = 0;
            for (std::size_t i = 0; i < guesses_.size(); ++i) {
                if (!belongs(i)) continue;
                weight += left[i];
                sum += left[i] * Eigen::Vector2d(guesses_[i].x, guesses_[i].y);
                fronts_sum += left[i] * fronts[i];
                error += left[i] * guesses_[i].log_error;
            }
            middle = sum / weight;
            front = fronts_sum / weight;
            if (front.norm() > 1e-6) front.normalize();
        }
        yaw = std::atan2(front.y(), front.x());
        double inside = 0;
        for (std::size_t i = 0; i < guesses_.size(); ++i) {
            if (!belongs(i)) continue;
            const Eigen::Vector3d off(guesses_[i].x - middle.x(), guesses_[i].y - middle.y(), wrap_angle(guesses_[i].yaw - yaw));
            spread += left[i] * off * off.transpose();
            inside += left[i];
            left[i] = 0;
        }
        spread /= inside;
        if (inside / all < least_share) break;
        spread.diagonal() += Eigen::Vector3d(1e-6, 1e-6, 1e-6);
        const bool known = spread(2, 2) < front_known * front_known;
        if (k == 0) result.error = std::exp(error / weight);
        result.places.push_back({{middle.x(), middle.y(), yaw}, spread, known, inside / all});
        taken += inside / all;
    }
    const auto vague = [&](const PlaceProposal& place) { return worst_sigma(place.covariance.topLeftCorner<2, 2>()) > reach; };
    const auto any = [&](const auto& what) { return std::any_of(result.places.begin(), result.places.end(), what); };
    const bool front_missing = shows_front_ && any([](const PlaceProposal& place) { return !place.yaw_known; });
    const bool one = !result.places.empty() && result.places.front().weight > 0.9;
    if (taken < enough || any(vague)) {
        result.reason = fmt::format("what it heard or saw {} times leaves its place open: it must drive on", used_);
    } else if (!one && waited < patience) {
        result.reason = fmt::format("{} places are possible, the likeliest by {:.0f} %: it must drive on", result.places.size(), 100 * result.places[0].weight);
    } else if (front_missing && (sees_ || waited < patience)) {
        result.reason = "its front is still unknown: it must drive on";
    }
    if (!result.reason.empty()) {
        result.places.clear();
        return result;
    }
    for (PlaceProposal& place : result.places) place.weight /= taken;
    return result;
}

}  // namespace roomfix
