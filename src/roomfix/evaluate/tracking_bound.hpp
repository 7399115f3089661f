// How well could any tracker know a robot from what its sources said? The posterior Cramer-Rao bound.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <vector>

#include "roomfix/evaluate/truth.hpp"
#include "roomfix/observation/fix.hpp"
#include "roomfix/smooth/measured.hpp"

namespace roomfix {

/// The Riccati recursion at the true states: the smallest covariance that a tracker can have.
/// Source: Tichavský, Muravchik and Nehorai 1998, with the noise that the observations state.
class TrackingBound {
public:
    /// True pose and rates at a time, and the true errors of the wheels where they are known.
    using TrueStates = std::function<StateVector(Nanoseconds)>;
    TrackingBound(const TrackingModels& models, int robot, TrueStates truth)
        : models_(models), robot_(static_cast<std::size_t>(robot)), truth_(std::move(truth)) {}

    void start(Nanoseconds time, const Eigen::Matrix3d& covariance);
    bool started() const { return started_; }
    /// `driven`: what the wheels said.
    void predict_to(Nanoseconds time, const OdometryTrack& driven);
    /// What is measured now, after `predict_to`.
    void learn(const Measured& measured);
    template <int Rows>
    void learn(Linearised<Rows> measured) {
        measured.residual.setZero();
        update(belief_, measured, {0.01, std::numeric_limits<double>::infinity(), -10});
    }
    /// Fisher information of a range about the distance, 1/m^2: less than 1/sigma^2 since some are late.
    double range_information(double sigma, const LateModel& late);
    /// For what prepares slow states.
    Belief& belief() { return belief_; }

private:
    void stand_at_truth(Nanoseconds time);

    const TrackingModels& models_;
    std::size_t robot_;
    TrueStates truth_;
    Belief belief_;
    Nanoseconds time_ = 0;
    bool started_ = false;
    std::map<double, double> information_;  // of ranges, by sigma
};

/// The bound of each fix's pose, from all that the tracker was told until then; nothing for robots without a name or a truth of their own.
/// `tracker` has kept its history. `truth` is used here only: it is where the models are linearised. `point`: of the robot, m, which it is about.
std::vector<std::optional<Eigen::Matrix3d>> tracking_bounds(const Tracker& tracker, const std::vector<Fix>& fixes, const Truth& truth,
                                                            const std::function<void(double)>& progress = {},
                                                            const Eigen::Vector2d& point = Eigen::Vector2d::Zero());

}  // namespace roomfix
