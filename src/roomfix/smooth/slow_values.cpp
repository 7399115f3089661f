#include "roomfix/smooth/slow_values.hpp"

#include <ceres/sized_cost_function.h>

#include <algorithm>
#include <cmath>

namespace roomfix {
namespace {

constexpr double fast_stretch = 20;       // s: what has to change more often does so with the slices
constexpr double forgotten = 3;           // memories after which a value starts anew
constexpr double least_change = 1e-3;     // of its standard deviation, from one value to the next
constexpr double longest = 1e5;           // s
constexpr double walking_stretch = 20;    // s
constexpr double for_ever = 1e9;          // s
constexpr double left_of_lasting = 0.05;  // of the variance, once it was estimated along ...
constexpr double left_of_fast = 0.3;      // ... from what a short while told
constexpr int of_core = -1;               // in place of a kind of slow state

/// Of one beacon or landmark only?
bool is_of_one_thing(const SlowState& state) {
    const bool by_component = state.kind == SlowKind::range_bias || state.kind == SlowKind::range_wander;
    return by_component && state.component >= 0;
}

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

long SlowValues::number_at(Nanoseconds time, double stretch) const { return static_cast<long>(std::floor(to_seconds(time - slices_.start(0)) / stretch)); }

const double* SlowValues::value_in(const Chain& chain, long number) {
    const long place = number - chain.first;
    return place >= 0 && place < static_cast<long>(chain.values.size()) ? chain.values[static_cast<std::size_t>(place)].get() : nullptr;
}

double* SlowValues::in_chain(const Key& key, const std::optional<SlowState>& state, double stretch, double sigma, double keep, double step_sigma,
                             Nanoseconds time) {
    const long number = number_at(time, stretch);
    const auto [found, fresh] = chains_.try_emplace(key);
    Chain& chain = found->second;
    if (fresh) {
        chain.state = state;
        chain.stretch = stretch;
        chain.first = number;
    }
    const Chain* known_values = nullptr;
    if (earlier_ != nullptr) {
        const auto there = earlier_->chains_.find(key);
        if (there != earlier_->chains_.end()) known_values = &there->second;
    }
    while (chain.first + static_cast<long>(chain.values.size()) <= number) {
        chain.values.push_back(std::make_unique<double>(0.0));
        double* value = chain.values.back().get();
        all_.push_back({value, state, std::nullopt});
        const double* known = known_values == nullptr ? nullptr : value_in(*known_values, chain.first + static_cast<long>(chain.values.size()) - 1);
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

const double* SlowValues::value_at(const Key& key, Nanoseconds time) const {
    const auto chain = fast_.find(key);
    if (chain == fast_.end()) return nullptr;
    const std::size_t slice = slices_.at(time);
    const std::vector<FastValue>& values = chain->second.values;
    const auto found = std::lower_bound(values.begin(), values.end(), slice, [](const FastValue& v, std::size_t s) { return v.slice < s; });
    return found != values.end() && found->slice == slice ? found->value.get() : nullptr;
}

void SlowValues::add_known(Belief& belief, int source, Nanoseconds time) const {
    const auto add = [&](const SlowState& state, const double* value, double left) {
        if (value == nullptr || state.source != source || is_of_one_thing(state)) return;
        const int index = ensure_slow(belief, state);
        belief.mean[index] = *value;
        belief.covariance(index, index) = left * state.variance;
    };
    for (const auto& [key, chain] : chains_) {
        if (chain.state) add(*chain.state, value_in(chain, number_at(time, chain.stretch)), left_of_lasting);
    }
    for (const auto& [key, chain] : fast_) add(chain.state, value_at(key, time), left_of_fast);
}

double* SlowValues::in_slice(const Key& key, const SlowState& state, Nanoseconds time) {
    const std::size_t slice = slices_.at(time);
    const ChangeRate rate{state.per_second, state.per_metre};
    std::vector<FastValue>& chain = fast_.try_emplace(key, FastChain{state, {}}).first->second.values;
    const auto add = [&](std::size_t at) {
        chain.push_back({at, std::make_unique<double>(0.0)});
        double* value = chain.back().value.get();
        all_.push_back({value, state, at});
        const double* known = earlier_ == nullptr ? nullptr : earlier_->value_at(key, slices_.start(at));
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
