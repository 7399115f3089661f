#include "roomfix/estimate/conviction.hpp"

#include <algorithm>

namespace roomfix {

void Conviction::temper(const std::vector<double>& before, std::vector<double>& after, Nanoseconds time, double nats_per_second) {
    constexpr double stock = 1;  // s worth of it that nothing has used
    const double passed = std::max(to_seconds(time - told_), 0.0);
    nats_ = std::min(nats_ + nats_per_second * std::min(passed, stock), nats_per_second * stock);
    told_ = std::max(told_, time);
    double least = 1e300, most = -1e300;
    for (std::size_t s = 0; s < before.size(); ++s) {
        const double more = after[s] - before[s];
        least = std::min(least, more);
        most = std::max(most, more);
    }
    if (!(most > least)) return;
    const double part = std::min(1.0, nats_ / (most - least));
    for (std::size_t s = 0; s < before.size(); ++s) after[s] = before[s] + most + part * (after[s] - before[s] - most);
    nats_ -= part * (most - least);
}

}  // namespace roomfix
