#include "roomfix/smooth/slow_values.hpp"

#include <ceres/sized_cost_function.h>

#include <algorithm>
#include <cmath>

namespace roomfix {
namespace {

constexpr double fast_stretch = 20;     // s: what has to change more often does so with the slices
constexpr double forgotten = 3;         // memories after which a value starts anew
constexpr double least_change = 1e-3;   // of its standard deviation, from one value to the next
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

/// How much of a value stays after so many memories, and the standard deviation of what comes to it.
std::pair<double, double> kept_and_added(double age, double variance) {
    const double keep = std::exp(-age);
    return {keep, std::sqrt(variance * std::max(1 - keep * keep, least_change * least_change))};
}

}  // namespace

bool changes_fast(const SlowState& state, double speed) { return (state.per_second + speed * state.per_metre) * fast_stretch > part_of_memory; }

const double* SlowValues::earlier_value(const Key& key, long number) const {
    if (earlier_ == nullptr) return nullptr;
    const auto chain = earlier_->chains_.find(key);
    if (chain == earlier_->chains_.end()) return nullptr;
    const long place = number - chain->second.first;
    return place >= 0 && place < static_cast<long>(chain->second.values.size()) ? chain->second.values[static_cast<std::size_t>(place)].get() : nullptr;
}

double* SlowValues::in_chain(const Key& key, const std::optional<SlowState>& state, double stretch, double sigma, double keep, double step_sigma,
                             Nanoseconds time) {
    const long number = static_cast<long>(std::floor(to_seconds(time - slices_.start(0)) / stretch));
    const auto [found, fresh] = chains_.try_emplace(key);
    Chain& chain = found->second;
    if (fresh) chain.first = number;
    while (chain.first + static_cast<long>(chain.values.size()) <= number) {
        chain.values.push_back(std::make_unique<double>(0.0));
        double* value = chain.values.back().get();
        all_.push_back({value, state, std::nullopt});
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

const double* SlowValues::earlier_fast(const Key& key, Nanoseconds time) const {
    if (earlier_ == nullptr) return nullptr;
    const auto chain = earlier_->fast_.find(key);
    if (chain == earlier_->fast_.end()) return nullptr;
    const std::size_t slice = earlier_->slices_.at(time);
    const auto found = std::lower_bound(chain->second.begin(), chain->second.end(), slice, [](const FastValue& v, std::size_t s) { return v.slice < s; });
    return found != chain->second.end() && found->slice == slice ? found->value.get() : nullptr;
}

double* SlowValues::in_slice(const Key& key, const SlowState& state, Nanoseconds time) {
    const std::size_t slice = slices_.at(time);
    const ChangeRate rate{state.per_second, state.per_metre};
    std::vector<FastValue>& chain = fast_[key];
    const auto add = [&](std::size_t at) {
        chain.push_back({at, std::make_unique<double>(0.0)});
        double* value = chain.back().value.get();
        all_.push_back({value, state, at});
        const double* known = earlier_fast(key, slices_.start(at));
        if (known != nullptr) *value = *known;
        return value;
    };
    if (chain.empty() || slices_.age(chain.back().slice, slice, rate) > forgotten) {
        double* value = add(slice);
        problem_.AddResidualBlock(new Prior(std::sqrt(state.variance)), nullptr, value);
        return value;
    }
    while (chain.back().slice < slice) {
        const std::size_t last = chain.back().slice;
        double* before = chain.back().value.get();
        double* value = add(last + 1);
        const auto [keep, added] = kept_and_added(slices_.age(last, last + 1, rate), state.variance);
        problem_.AddResidualBlock(new Tie(keep, added), nullptr, before, value);
    }
    return chain.back().value.get();
}

double* SlowValues::of(const SlowState& state, Nanoseconds time) {
    const Key key{static_cast<int>(state.kind), state.source, state.component};
    if (lasting_ && is_lasting(state.kind)) return in_chain(key, state, for_ever, std::sqrt(state.variance), 1, 1, time);
    if (changes_fast(state, speed_)) return in_slice(key, state, time);
    const double per_second = state.per_second + speed_ * state.per_metre;
    const double stretch = per_second > 0 ? std::min(part_of_memory / per_second, longest) : longest;
    const auto [keep, added] = kept_and_added(stretch * per_second, state.variance);
    return in_chain(key, state, stretch, std::sqrt(state.variance), keep, added, time);
}

double* SlowValues::walking(int core, double sigma, double walk, Nanoseconds time) {
    return in_chain({of_core, core, 0}, std::nullopt, walking_stretch, sigma, 1, walk * std::sqrt(walking_stretch), time);
}

}  // namespace roomfix
