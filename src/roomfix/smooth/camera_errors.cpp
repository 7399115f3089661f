#include "roomfix/smooth/camera_errors.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <tuple>

#include "roomfix/base/decompositions.hpp"
#include "roomfix/smooth/slow_values.hpp"
#include "roomfix/smooth/stretch.hpp"

namespace roomfix {
namespace {

/// Errors of unit variance that robots have in common, as information about them.
class SharedErrors {
public:
    using Key = std::tuple<SlowKind, int, int>;

    /// Adds what one robot's way tells beyond what was known.
    void add(const SmoothedStretch& stretch) {
        std::vector<Eigen::Index> own, shared;  // places in the stretch, and here
        for (std::size_t i = 0; i < stretch.slow.size(); ++i) {
            const auto& state = stretch.slow[i].state;
            if (!state || !is_lasting(state->kind)) continue;
            own.push_back(static_cast<Eigen::Index>(i));
            shared.push_back(place_of({state->kind, state->source, state->component}));
        }
        const auto count = static_cast<Eigen::Index>(own.size());
        Eigen::VectorXd mean(count);
        for (Eigen::Index i = 0; i < count; ++i) mean[i] = stretch.slow[static_cast<std::size_t>(own[static_cast<std::size_t>(i)])].value;
        const Eigen::MatrixXd information = Eigen::MatrixXd(stretch.covariance.common(own, own)).llt().solve(Eigen::MatrixXd::Identity(count, count));
        const auto all = static_cast<Eigen::Index>(keys_.size());
        const Eigen::Index before = information_.rows();
        information_.conservativeResize(all, all);
        pull_.conservativeResize(all);
        information_.rightCols(all - before).setZero();
        information_.bottomRows(all - before).setZero();
        pull_.tail(all - before).setZero();
        information_(shared, shared) += information - Eigen::MatrixXd::Identity(count, count);
        pull_(shared) += information * mean;
    }

    void solve() {
        covariance_ = (information_ + Eigen::MatrixXd::Identity(information_.rows(), information_.cols())).inverse();
        mean_ = covariance_ * pull_;
    }

    /// Errors that nothing was learned about keep what was known of them.
    SixErrors of_camera(int source) const {
        SixErrors six;
        six.source = source;
        std::array<Eigen::Index, 6> place{};
        for (int i = 0; i < 6; ++i) {
            const auto found = keys_.find({SlowKind::calibration, source, i});
            place[static_cast<std::size_t>(i)] = found == keys_.end() ? -1 : found->second;
        }
        for (int i = 0; i < 6; ++i) {
            const Eigen::Index row = place[static_cast<std::size_t>(i)];
            if (row < 0) continue;
            six.mean[i] = mean_[row];
            for (int j = 0; j < 6; ++j) {
                const Eigen::Index column = place[static_cast<std::size_t>(j)];
                if (column >= 0) six.covariance(i, j) = covariance_(row, column);
            }
        }
        return six;
    }

private:
    Eigen::Index place_of(const Key& key) { return keys_.try_emplace(key, static_cast<Eigen::Index>(keys_.size())).first->second; }

    std::map<Key, Eigen::Index> keys_;
    Eigen::MatrixXd information_, covariance_;
    Eigen::VectorXd pull_, mean_;
};

}  // namespace

std::vector<SixErrors> camera_errors_of(const Tracker& tracker, const std::vector<Fix>& tracked, const std::function<void(double)>& progress) {
    std::vector<SixErrors> cameras;
    if (tracker.history() == nullptr || tracked.empty()) return cameras;
    // Outlines, corners and lamps err alike wherever a robot is seen alike: over about a metre, and some 40 degrees.
    const SmootherSettings settings{.window = 0, .lasting = true, .same_place = 1, .same_heading = 0.7};
    const Trajectories trajectories = first_trajectories(tracker, tracked, settings);
    SharedErrors shared;
    std::map<int, SightingCount> sightings;
    for (std::size_t r = 0; r < trajectories.size(); ++r) {
        if (!trajectories[r]) continue;
        const auto report = [&](double part) {
            if (progress) progress((static_cast<double>(r) + part) / static_cast<double>(trajectories.size()));
        };
        const SmoothingTask task{static_cast<int>(r), *tracker.history(), tracker.groups(), tracker.models(), settings};
        const SmoothedStretch stretch = smooth_stretch(task, *trajectories[r], trajectories, report);
        if (stretch.covariance.pairs.empty()) continue;
        shared.add(stretch);
        for (const auto& [source, count] : stretch.counts) {
            sightings[source].all += count.all;
            sightings[source].doubted += count.doubted;
        }
    }
    shared.solve();
    const auto add = [&](int source, bool exact) {
        const auto seen = sightings.find(source);
        if (exact || seen == sightings.end()) return;
        cameras.push_back(shared.of_camera(source));
        cameras.back().sightings = seen->second;
    };
    for (const auto& [source, view] : tracker.models().views) add(source, view.calibration.isZero(0));
    for (const auto& [source, camera] : tracker.models().onboard) add(source, camera.calibration.isZero(0));
    std::sort(cameras.begin(), cameras.end(), [](const SixErrors& a, const SixErrors& b) { return a.source < b.source; });
    return cameras;
}

}  // namespace roomfix
