#include "roomfix/smooth/smoother.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "roomfix/smooth/stretch.hpp"

namespace roomfix {
namespace {

/// The fix as the smoothed trajectory has it.
void correct(Fix& fix, const SmoothedStretch& stretch, const SmoothingTask& task) {
    const Trajectory& way = stretch.trajectory;
    const std::size_t k = way.knot_before(fix.time);
    const double part = way.part_in(k, fix.time);
    const KnotWeights weights = way.weights_in(k, fix.time);
    Eigen::Matrix<double, 3, 12> by_pair;
    for (int i = 0; i < 4; ++i) by_pair.middleCols<3>(3 * i) = weights(0, i) * Eigen::Matrix3d::Identity();
    Eigen::Matrix3d covariance = by_pair * stretch.covariance.pairs[k] * by_pair.transpose();
    // Between the knots the robot may swing a little: white noise pinned at both ends.
    const auto robot = static_cast<std::size_t>(task.robot);
    const MotionModel& motion = task.models.motion[robot];
    const double swing = std::pow(part * (1 - part) * way.seconds_after(k), 3) / 3;
    covariance.diagonal() += swing * Eigen::Vector3d(motion.acceleration, motion.acceleration, motion.turning).cwiseAbs2();
    fix.velocity.reset();  // the tracker's: it knew less
    fix.nis.clear();
    fix.hypotheses.clear();
    const double sigma = worst_sigma(covariance.topLeftCorner<2, 2>());
    if (!(sigma < task.models.site.lost)) {
        fix.status = FixStatus::none;
        fix.sources.clear();
        fix.yaw_known = false;
        fix.reason = fmt::format("with all that came later, too, it may be anywhere within {:.1f} m", 2 * sigma);
        return;
    }
    const Knot at = between(way.knots[k], way.knots[k + 1], weights);
    fix.pose = {at[0], at[1], wrap_angle(at[2])};
    fix.covariance = 0.5 * (covariance + covariance.transpose());
    if (fix.status == FixStatus::none) fix.status = FixStatus::coasting;
    fix.yaw_known = covariance(2, 2) < 0.25;
    fix.reason.clear();
}

}  // namespace

Smoothed smooth(const Tracker& tracker, const std::vector<Fix>& tracked, const SmootherSettings& settings, const std::function<void(double)>& progress) {
    Smoothed smoothed{tracked, {}};
    if (tracker.history() == nullptr || tracked.empty()) return smoothed;
    const TrackingModels models = tracker.learned_models();
    const std::size_t robots = models.site.robots.size();
    std::vector<std::vector<std::size_t>> places_of(robots);  // in `smoothed`
    for (std::size_t i = 0; i < tracked.size(); ++i) {
        if (const auto robot = models.site.robot(tracked[i].robot)) places_of[static_cast<std::size_t>(*robot)].push_back(i);
    }
    const Trajectories trajectories = first_trajectories(tracker, tracked, settings);
    for (std::size_t r = 0; r < robots; ++r) {
        if (!trajectories[r]) continue;
        const SmoothingTask task{static_cast<int>(r), *tracker.history(), tracker.groups(), models, settings};
        const Trajectory& whole = *trajectories[r];
        const Nanoseconds window = settings.window > 0 ? from_seconds(settings.window) : whole.end() - whole.start();
        const Nanoseconds overlap = from_seconds(settings.overlap);
        std::size_t next = 0;
        for (Nanoseconds from = whole.start(); from < whole.end(); from += window) {
            const Nanoseconds to = from + window;
            const SmoothedStretch stretch = smooth_stretch(task, whole.part(from - overlap, to + overlap), trajectories);
            std::vector<std::size_t> within;
            for (; next < places_of[r].size() && (tracked[places_of[r][next]].time < to || to >= whole.end()); ++next) {
                within.push_back(places_of[r][next]);
            }
            if (stretch.covariance.pairs.empty() || !stretch.settled) {
                smoothed.unsettled.push_back({models.site.robots[r].id, from, std::min(to, whole.end())});
            } else {
                for (const std::size_t i : within) {
                    if (stretch.trajectory.covers(smoothed.fixes[i].time)) correct(smoothed.fixes[i], stretch, task);
                }
            }
            if (progress)
                progress((static_cast<double>(r) + std::min(1.0, to_seconds(to - whole.start()) / to_seconds(whole.end() - whole.start()))) /
                         static_cast<double>(robots));
        }
    }
    return smoothed;
}

}  // namespace roomfix
