#include "roomfix/estimate/start_search.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <tuple>

namespace roomfix {
namespace {

constexpr std::size_t most_used = 80;      // that a place is refined with ...
constexpr std::size_t most_in_cells = 24;  // ... and that cells of the grid are compared with
constexpr int cells = 28;                  // along the longer side of the area
constexpr int yaws = 24;
constexpr std::size_t most_refined = 40;
constexpr std::size_t most_places = 8;
constexpr double without_wheels = 2.5;  // s: older ranges say nothing where nobody knows how the robot drives
constexpr double walking = 0.5;         // m/s, of a robot of which nobody knows
constexpr double wheel_error = 0.05;    // part of the way
constexpr double alike_after = 2;       // s: errors of one source are alike for so long
constexpr double degrees_of_freedom = 4;
constexpr double bias_of_error = 2;  // how much larger than the scatter what all ranges have in common may be

/// Something heard, with where the robot was then, seen from where it is now.
struct Clue {
    const Heard* heard = nullptr;
    Pose2 then;
    double spread = 0;  // m: how far `then` may be off
};

/// x, y, yaw, and by how much all ranges are too long
using Unknowns = Eigen::Vector4d;
using Residuals = Eigen::VectorXd;

class Search {
public:
    Search(std::span<const Heard> heard, int robot, const TrackingModels& models) : robot_(robot), models_(models) {
        const Nanoseconds now = time_of(heard.back());
        const OdometryTrack& driven = models.driven[static_cast<std::size_t>(robot)];
        drives_ = !driven.empty();
        const std::size_t from = first_used(heard);
        const std::size_t stride = (heard.size() - from + most_used - 1) / most_used;
        for (std::size_t i = heard.size(); i-- > from;) {
            if ((heard.size() - 1 - i) % stride != 0) continue;
            Clue clue{&heard[i]};
            const double age = to_seconds(now - time_of(heard[i]));
            if (const auto step = driven.step(time_of(heard[i]), now); step && drives_) {
                const Eigen::Vector2d back = -(Eigen::Rotation2Dd(-step->turned) * step->way);
                clue.then = {back.x(), back.y(), -step->turned};
                clue.spread = wheel_error * step->way.norm();
                way_ = std::max(way_, step->way.norm());
            } else {
                clue.spread = walking * age;
            }
            clues_.push_back(clue);
        }
        std::set<std::tuple<std::size_t, int, long>> apart;
        for (const Clue& clue : clues_) {
            const auto span = static_cast<long>(to_seconds(time_of(*clue.heard)) / alike_after);
            apart.insert({clue.heard->index(), thing_of(*clue.heard), span});
            things_.insert(thing_of(*clue.heard));
            turns_ |= sees_direction(*clue.heard);
        }
        turns_ |= drives_ && way_ > least_way;
        independent_ = static_cast<double>(apart.size()) / static_cast<double>(clues_.size());
    }

    std::size_t things() const { return things_.size(); }
    std::size_t count() const { return clues_.size(); }
    double way() const { return way_; }
    bool drives() const { return drives_; }

    struct Found {
        Unknowns at = Unknowns::Zero();
        double error = 0;  // m
        double log_weight = 0;
        Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();
        bool yaw_known = false;
    };

    /// Places worked out, the likeliest first.
    std::vector<Found> run() {
        std::vector<Found> found;
        for (const Unknowns& start : best_cells()) {
            if (auto refined = refine(start)) found.push_back(*refined);
        }
        std::stable_sort(found.begin(), found.end(), [](const Found& a, const Found& b) { return a.log_weight > b.log_weight; });
        std::vector<Found> different;
        for (const Found& f : found) {
            const bool known = std::any_of(different.begin(), different.end(), [&](const Found& other) { return same(other, f); });
            if (!known && different.size() < most_places && f.log_weight > found.front().log_weight - 8) different.push_back(f);
        }
        return different;
    }

private:
    static constexpr double least_way = 0.3;  // m: less tells no direction

    static int thing_of(const Heard& heard) {
        if (const auto* range = std::get_if<RangeObservation>(&heard)) return range->beacon;
        if (const auto* difference = std::get_if<RangeDifferenceObservation>(&heard)) return difference->beacons[0] * 1000 + difference->beacons[1];
        return std::get<SightingObservation>(heard).landmark;
    }
    static bool sees_direction(const Heard& heard) {
        const auto* sighting = std::get_if<SightingObservation>(&heard);
        return sighting != nullptr && sighting->bearing.has_value();
    }

    std::size_t first_used(std::span<const Heard> heard) const {
        if (drives_) return 0;
        std::size_t from = heard.size() - 1;
        while (from > 0 && to_seconds(time_of(heard.back()) - time_of(heard[from - 1])) < without_wheels) --from;
        return from;
    }

    double stated_sigma(const Heard& heard) const {
        if (const auto* range = std::get_if<RangeObservation>(&heard)) return range->sigma;
        if (const auto* difference = std::get_if<RangeDifferenceObservation>(&heard)) return difference->sigma;
        const auto& sighting = std::get<SightingObservation>(heard);
        return std::max(sighting.range ? sighting.range_sigma : 0.0, sighting.bearing_sigma * sighting.range.value_or(1));
    }

    const Eigen::Vector3d& beacon(int number) const { return models_.site.beacons[static_cast<std::size_t>(number)].position; }

    Eigen::Vector3d ear_of(const Pose2& robot, int number) const {
        const RangeSource& receiver = models_.receiver(robot_, number);
        Eigen::Vector3d arm = receiver.receiver;
        if (!turns_) arm.head<2>().setZero();
        arm.head<2>() = Eigen::Rotation2Dd(robot.yaw) * arm.head<2>() + Eigen::Vector2d(robot.x, robot.y);
        return arm;
    }

    /// How far what was heard is from what would be heard there, m: two numbers, of which the second is a bearing's.
    Eigen::Vector2d off(const Clue& clue, const Unknowns& at) const {
        const Eigen::Vector2d place = at.head<2>() + Eigen::Rotation2Dd(at[2]) * Eigen::Vector2d(clue.then.x, clue.then.y);
        const Pose2 robot{place.x(), place.y(), at[2] + clue.then.yaw};
        if (const auto* range = std::get_if<RangeObservation>(clue.heard)) {
            return {range->range - (ear_of(robot, range->receiver) - beacon(range->beacon)).norm() - at[3], 0};
        }
        if (const auto* difference = std::get_if<RangeDifferenceObservation>(clue.heard)) {
            const Eigen::Vector3d ear = ear_of(robot, difference->receiver);
            return {difference->difference - ((ear - beacon(difference->beacons[1])).norm() - (ear - beacon(difference->beacons[0])).norm()), 0};
        }
        const auto& sighting = std::get<SightingObservation>(*clue.heard);
        if (sighting.landmark >= 0) return off_from(sighting, robot, sighting.landmark);
        Eigen::Vector2d least(1e6, 0);
        for (std::size_t i = 0; i < models_.marks.size(); ++i) {
            if (!models_.marks[i].plain) continue;
            const Eigen::Vector2d tried = off_from(sighting, robot, static_cast<int>(i));
            if (tried.squaredNorm() < least.squaredNorm()) least = tried;
        }
        return least;
    }

    Eigen::Vector2d off_from(const SightingObservation& sighting, const Pose2& robot, int landmark) const {
        const PredictedSighting exact = predict_sighting(robot, models_.marks[static_cast<std::size_t>(landmark)].place);
        return {sighting.range ? *sighting.range - exact.range : 0,
                sighting.bearing ? exact.range * wrap_angle(*sighting.bearing - exact.bearing) : 0};
    }

    bool usable_in_cell(std::size_t i) const { return i % std::max<std::size_t>(clues_.size() / most_in_cells, 1) == 0; }

    Eigen::AlignedBox2d area() const {
        Eigen::AlignedBox2d box;
        double farthest = 0;
        for (const Clue& clue : clues_) {
            const auto reach_of = [&](const Eigen::Vector2d& from, double reach) {
                Eigen::AlignedBox2d around(from - Eigen::Vector2d::Constant(reach), from + Eigen::Vector2d::Constant(reach));
                box = box.isEmpty() ? around : box.merged(around);
                farthest = std::max(farthest, reach);
            };
            if (const auto* range = std::get_if<RangeObservation>(clue.heard)) {
                reach_of(beacon(range->beacon).head<2>(), range->range);
            } else if (const auto* difference = std::get_if<RangeDifferenceObservation>(clue.heard)) {
                const double apart = (beacon(difference->beacons[0]) - beacon(difference->beacons[1])).norm();
                for (const int b : difference->beacons) reach_of(beacon(b).head<2>(), apart);
            } else {
                const auto& sighting = std::get<SightingObservation>(*clue.heard);
                for (std::size_t i = 0; i < models_.marks.size(); ++i) {
                    if (sighting.landmark < 0 || sighting.landmark == static_cast<int>(i)) reach_of(models_.marks[i].place, sighting.range.value_or(5));
                }
            }
        }
        return box;
    }

    std::vector<Unknowns> best_cells() const {
        const Eigen::AlignedBox2d box = area();
        const double step = std::max(box.sizes().maxCoeff() / cells, 0.05);
        const int turns = turns_ ? yaws : 1;
        struct Cell {
            double cost;
            Unknowns at;
        };
        std::vector<Cell> all;
        for (double x = box.min().x() + 0.5 * step; x < box.max().x(); x += step) {
            for (double y = box.min().y() + 0.5 * step; y < box.max().y(); y += step) {
                for (int turn = 0; turn < turns; ++turn) {
                    const Unknowns at(x, y, turn * 2 * std::numbers::pi / turns, 0);
                    double cost = 0;
                    for (std::size_t i = 0; i < clues_.size(); ++i) {
                        if (usable_in_cell(i)) cost += std::log1p(off(clues_[i], at).squaredNorm() / (step * step + clues_[i].spread * clues_[i].spread));
                    }
                    all.push_back({cost, at});
                }
            }
        }
        std::stable_sort(all.begin(), all.end(), [](const Cell& a, const Cell& b) { return a.cost < b.cost; });
        std::vector<Unknowns> best;
        for (const Cell& cell : all) {
            const bool near = std::any_of(best.begin(), best.end(), [&](const Unknowns& other) {
                return (other - cell.at).head<2>().norm() < 1.5 * step && std::abs(wrap_angle(other[2] - cell.at[2])) < 0.6;
            });
            if (!near) best.push_back(cell.at);
            if (best.size() == most_refined) break;
        }
        return best;
    }

    /// Standard deviation of one clue, m, where the scatter is `error`.
    double sigma_of(const Clue& clue, double error) const { return std::sqrt(error * error + clue.spread * clue.spread); }

    double median_off(const std::vector<Eigen::Vector2d>& offs) const {
        std::vector<double> sizes;
        for (const Eigen::Vector2d& o : offs) sizes.push_back(o.norm());
        std::nth_element(sizes.begin(), sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2), sizes.end());
        const double unknowns = turns_ ? 3 : 2;
        const auto n = static_cast<double>(sizes.size());
        return 1.4826 * sizes[sizes.size() / 2] * std::sqrt(n / std::max(n - unknowns, 0.5));
    }

    std::vector<Eigen::Vector2d> offs_at(const Unknowns& at) const {
        std::vector<Eigen::Vector2d> offs;
        for (const Clue& clue : clues_) offs.push_back(off(clue, at));
        return offs;
    }

    double log_likelihood(const std::vector<Eigen::Vector2d>& offs, const Unknowns& at, double error) const {
        double sum = -0.5 * std::pow(at[3] / (bias_of_error * error), 2);
        for (std::size_t i = 0; i < clues_.size(); ++i) {
            const double sigma = sigma_of(clues_[i], error);
            const int rows = sees_direction(*clues_[i].heard) ? 2 : 1;
            sum -= rows * std::log(sigma) + 0.5 * (degrees_of_freedom + rows) * std::log1p(offs[i].squaredNorm() / (degrees_of_freedom * sigma * sigma));
        }
        return sum;
    }

    std::optional<Found> refine(const Unknowns& start) const {
        Unknowns at = start;
        double least_error = 1e300;
        for (const Clue& clue : clues_) least_error = std::min(least_error, stated_sigma(*clue.heard));
        Eigen::Matrix4d information;
        double error = least_error;
        double damping = 1e-3;
        for (int iteration = 0; iteration < 25; ++iteration) {
            const auto offs = offs_at(at);
            error = std::max(least_error, median_off(offs));
            information = Eigen::Matrix4d::Zero();
            Eigen::Vector4d gradient = Eigen::Vector4d::Zero();
            for (std::size_t i = 0; i < clues_.size(); ++i) {
                const double variance = std::pow(sigma_of(clues_[i], error), 2);
                const double weight = (degrees_of_freedom + 1) / (degrees_of_freedom + offs[i].squaredNorm() / variance) / variance;
                const Eigen::Matrix<double, 2, 4> slope = slope_of(clues_[i], at);
                information += weight * slope.transpose() * slope;
                gradient -= weight * slope.transpose() * offs[i];
            }
            const double prior = 1 / std::pow(bias_of_error * error, 2);
            information(3, 3) += prior;
            gradient[3] -= prior * at[3];
            if (!turns_) {
                information.row(2).setZero();
                information.col(2).setZero();
                information(2, 2) = 1;
                gradient[2] = 0;
            }
            const Eigen::Matrix4d damped = information + damping * Eigen::Vector4d(information.diagonal()).asDiagonal().toDenseMatrix();
            const Eigen::Vector4d step = damped.ldlt().solve(gradient);
            if (!step.allFinite()) return std::nullopt;
            const Unknowns moved = at + step;
            if (log_likelihood(offs_at(moved), moved, error) >= log_likelihood(offs, at, error)) {
                at = moved;
                damping = std::max(0.2 * damping, 1e-6);
                if (step.head<2>().norm() < 1e-4 && std::abs(step[2]) < 1e-4) break;
            } else {
                damping *= 8;
                if (damping > 1e6) break;
            }
        }
        const Eigen::FullPivLU<Eigen::Matrix4d> factor(information);
        if (!factor.isInvertible()) return std::nullopt;
        Found found;
        found.at = at;
        found.at[2] = wrap_angle(at[2]);
        found.error = error;
        found.log_weight = independent_ * log_likelihood(offs_at(at), at, error);
        found.covariance = factor.inverse().topLeftCorner<3, 3>() / independent_;
        found.yaw_known = turns_ && found.covariance(2, 2) < 0.3 * 0.3;
        if (!(found.covariance.diagonal().minCoeff() > 0) || !found.covariance.allFinite()) return std::nullopt;
        return found;
    }

    Eigen::Matrix<double, 2, 4> slope_of(const Clue& clue, const Unknowns& at) const {
        constexpr double step = 1e-4;
        Eigen::Matrix<double, 2, 4> slope;
        for (int i = 0; i < 4; ++i) {
            Unknowns less = at, more = at;
            less[i] -= step;
            more[i] += step;
            slope.col(i) = (off(clue, more) - off(clue, less)) / (2 * step);
        }
        return slope;
    }

    bool same(const Found& a, const Found& b) const {
        Eigen::Vector3d apart = (a.at - b.at).head<3>();
        apart[2] = turns_ ? wrap_angle(apart[2]) : 0;
        if (apart.head<2>().norm() < 1e-2 && std::abs(apart[2]) < 1e-2) return true;
        return apart.dot(Eigen::Matrix3d(a.covariance + b.covariance).inverse() * apart) < 9;
    }

    int robot_;
    const TrackingModels& models_;
    std::vector<Clue> clues_;
    std::set<int> things_;
    double way_ = 0;          // m, driven meanwhile
    double independent_ = 1;  // part of the clues that tell something new
    bool drives_ = false;
    bool turns_ = false;  // the clues tell a direction
};

}  // namespace

Nanoseconds time_of(const Heard& heard) {
    return std::visit([](const auto& h) { return h.time; }, heard);
}

StartPlaces search_start(std::span<const Heard> heard, int robot, const TrackingModels& models, double patience) {
    constexpr double sure = 0.8;    // weight of a place that needs no patience
    constexpr double unclear = 0.3; // weight of the likeliest of several
    StartPlaces result;
    if (heard.size() < 3) {
        result.reason = fmt::format("only {} ranges or sightings came", heard.size());
        return result;
    }
    Search search(heard, robot, models);
    const auto found = search.run();
    if (found.empty()) {
        result.reason = fmt::format("{} ranges or sightings of {} beacons or landmarks leave its place open", search.count(), search.things());
        return result;
    }
    const double waited = to_seconds(time_of(heard.back()) - time_of(heard.front()));
    double sum = 0;
    for (const auto& f : found) sum += std::exp(f.log_weight - found[0].log_weight);
    const double best = 1 / sum;
    const double sigma = worst_sigma(found[0].covariance.topLeftCorner<2, 2>());
    const bool impatient = waited > patience;
    if (!(sigma < models.settings.anywhere)) {
        result.reason = fmt::format("{} ranges or sightings of {} beacons or landmarks tell its place to {:.1f} m only", search.count(), search.things(), sigma);
        return result;
    }
    if (best < (impatient ? unclear : sure) || (!impatient && search.drives() && !found[0].yaw_known)) {
        result.reason = best < sure ? fmt::format("{} places are possible, the likeliest by {:.0f} %: it must drive on", found.size(), 100 * best)
                                    : "its front is still unknown: it must drive on";
        return result;
    }
    for (const auto& f : found) {
        result.places.push_back({{f.at[0], f.at[1], f.at[2]}, f.covariance, f.yaw_known, std::exp(f.log_weight - found[0].log_weight) / sum});
    }
    result.error = found[0].error;
    result.bias = found[0].at[3];
    return result;
}

}  // namespace roomfix
