#include "roomfix/overhead/expected_places.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "roomfix/base/decompositions.hpp"

namespace roomfix {

void ExpectedPlaces::begin(const Expectation& expected, std::size_t robots) {
    robots_.assign(robots, nullptr);
    for (const PoseObservation& e : expected.robots) {
        const bool well = e.covariance.topLeftCorner<2, 2>().trace() < settings_.within * settings_.within;
        if (well) robots_[static_cast<std::size_t>(e.robot)] = &e;
    }
    things_ = expected.things;
    nameless_ = expected.nameless;
}

double ExpectedPlaces::prior_of(int robot, const Pose2& pose) const {
    const PoseObservation* expected = robots_[static_cast<std::size_t>(robot)];
    return expected ? odds_here(*expected, pose) : 0;
}

std::optional<double> ExpectedPlaces::prior_of_thing(const Pose2& pose) const {
    std::optional<double> most;
    for (const PoseObservation& thing : things_) {
        if (is_at_place(thing, pose)) most = std::max(most.value_or(0), odds_here(thing, pose));
    }
    return most;
}

double ExpectedPlaces::odds_here(const PoseObservation& expected, const Pose2& pose) const {
    constexpr double least = 0.02;  // m: bodies are found no better
    const Eigen::Matrix2d spread = expected.covariance.topLeftCorner<2, 2>() + least * least * Eigen::Matrix2d::Identity();
    const Eigen::Vector2d off(pose.x - expected.pose.x, pose.y - expected.pose.y);
    const double density = std::exp(-0.5 * off.dot(spread.inverse() * off)) / (2 * std::numbers::pi * std::sqrt(spread.determinant()));
    return std::log((1 - settings_.surprise) * density * settings_.floor + settings_.surprise);
}

double ExpectedPlaces::nowhere() const { return std::log(settings_.surprise); }

bool is_at_place(const PoseObservation& expected, const Pose2& pose) {
    constexpr double nearby = 9;  // squared Mahalanobis distance
    const Eigen::Vector2d off(pose.x - expected.pose.x, pose.y - expected.pose.y);
    return off.dot(expected.covariance.topLeftCorner<2, 2>().inverse() * off) < nearby;
}

}  // namespace roomfix
