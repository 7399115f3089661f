#include "roomfix/smooth/slow_values.hpp"

#include <ceres/sized_cost_function.h>

#include <algorithm>
#include <cmath>

namespace roomfix {
namespace {

constexpr double part_of_memory = 0.2;  // over which a value may be taken for constant
constexpr double shortest = 1;          // s
constexpr double longest = 1e5;         // s
constexpr double walking_stretch = 20;  // s
constexpr double for_ever = 1e9;        // s
constexpr int of_core = -1;             // in place of a kind of slow state

/// value / sigma
class Prior final : public ceres::SizedCostFunction<1, 1> {
public:
    explicit Prior(double sigma) : per_sigma_(1 / sigma) {}
    bool Evaluate(double const* const* values, double* residual, double** jacobians) const override {
        residual[0] = per_sigma_ * values[0][0];
        if (jacobians != nullptr && jacobians[0] != nullptr) jacobians[0][0] = per_sigma_;
        return true;
    }

private:
    double per_sigma_;
};

/// (next - keep * value) / sigma
class Tie final : public ceres::SizedCostFunction<1, 1, 1> {
public:
    Tie(double keep, double sigma) : keep_(keep), per_sigma_(1 / sigma) {}
    bool Evaluate(double const* const* values, double* residual, double** jacobians) const override {
        residual[0] = per_sigma_ * (values[1][0] - keep_ * values[0][0]);
        if (jacobians == nullptr) return true;
        if (jacobians[0] != nullptr) jacobians[0][0] = -keep_ * per_sigma_;
        if (jacobians[1] != nullptr) jacobians[1][0] = per_sigma_;
        return true;
    }

private:
    double keep_, per_sigma_;
};

}  // namespace

const double* SlowValues::earlier_value(const Key& key, long number) const {
    if (earlier_ == nullptr) return nullptr;
    const auto chain = earlier_->chains_.find(key);
    if (chain == earlier_->chains_.end()) return nullptr;
    const long place = number - chain->second.first;
    return place >= 0 && place < static_cast<long>(chain->second.values.size()) ? chain->second.values[static_cast<std::size_t>(place)].get() : nullptr;
}

double* SlowValues::in_chain(const Key& key, const std::optional<SlowState>& state, double stretch, double sigma, double keep, double step_sigma,
                             Nanoseconds time) {
    const long number = static_cast<long>(std::floor(to_seconds(time - start_) / stretch));
    const auto [found, fresh] = chains_.try_emplace(key);
    Chain& chain = found->second;
    if (fresh) chain.first = number;
    while (chain.first + static_cast<long>(chain.values.size()) <= number) {
        chain.values.push_back(std::make_unique<double>(0.0));
        double* value = chain.values.back().get();
        all_.push_back({value, state});
        const double* known = earlier_value(key, chain.first + static_cast<long>(chain.values.size()) - 1);
        if (known != nullptr) *value = *known;
        if (chain.values.size() == 1) {
            problem_.AddResidualBlock(new Prior(sigma), nullptr, value);
            continue;
        }
        double* before = chain.values[chain.values.size() - 2].get();
        if (known == nullptr) *value = keep * *before;
        problem_.AddResidualBlock(new Tie(keep, step_sigma), nullptr, before, value);
    }
    return chain.values[static_cast<std::size_t>(std::max(number - chain.first, 0L))].get();
}

double* SlowValues::of(const SlowState& state, Nanoseconds time) {
    const Key key{static_cast<int>(state.kind), state.source, state.component};
    if (lasting_ && is_lasting(state.kind)) return in_chain(key, state, for_ever, std::sqrt(state.variance), 1, 1, time);
    const double per_second = state.per_second + speed_ * state.per_metre;
    const double memory = per_second > 0 ? 1 / per_second : longest / part_of_memory;
    const double stretch = std::clamp(part_of_memory * memory, shortest, longest);
    const double keep = std::exp(-stretch * per_second);
    const double step = std::sqrt(std::max(state.variance * (1 - keep * keep), 1e-6 * state.variance));
    return in_chain(key, state, stretch, std::sqrt(state.variance), keep, step, time);
}

double* SlowValues::walking(int core, double sigma, double walk, Nanoseconds time) {
    return in_chain({of_core, core, 0}, std::nullopt, walking_stretch, sigma, 1, walk * std::sqrt(walking_stretch), time);
}

}  // namespace roomfix
