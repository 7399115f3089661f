// What the smoother minimises: squared, weighted differences between the trajectory and what was measured or driven.
#pragma once

#include <ceres/cost_function.h>
#include <ceres/loss_function.h>

#include <memory>
#include <vector>

#include "roomfix/estimate/tracking_models.hpp"
#include "roomfix/smooth/measured.hpp"

namespace roomfix {

/// A term over the knots before and after its time, and over slow errors.
struct MeasuredTerm {
    std::unique_ptr<ceres::CostFunction> cost;
    std::vector<SlowState> slow;  // its further parameters, in their order
    int dimensions = 0;
    bool has_tails = false;  // its own form makes room for outliers
};

/// The tracker's own measurement models on the interpolated trajectory. Nothing where the observation is out of sight there.
MeasuredTerm measured_term(const Measured& measured, int robot, const Trajectory& trajectory, const TrackingModels& models);

/// Parameters: knot, next knot. The motion by momentum of estimate/motion.
std::unique_ptr<ceres::CostFunction> momentum_term(double seconds, const MotionModel& model);

/// Parameters: knot, next knot, scale of the wheels' way, scale of their turning, drift.
std::unique_ptr<ceres::CostFunction> wheel_term(const OdometryStep& step, const OdometryNoise& noise);

/// Parameter: knot. Keeps it finite where nothing else does.
std::unique_ptr<ceres::CostFunction> loose_term(const Knot& about);

/// Right, or wrong altogether: the tracker's own weight of a squared distance, `gate` where both are equally likely. `least` weight is left
/// to what is surely wrong.
class OutlierLoss final : public ceres::LossFunction {
public:
    explicit OutlierLoss(double gate, double least = 0) : gate_(gate), least_(least) {}
    void Evaluate(double squared, double out[3]) const override;

private:
    double gate_, least_;
};

}  // namespace roomfix
