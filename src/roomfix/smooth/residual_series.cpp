#include "roomfix/smooth/residual_series.hpp"

#include <algorithm>
#include <numeric>

namespace roomfix {
namespace {

constexpr std::size_t most_lags = 40;
constexpr Nanoseconds farthest = 2'000'000'000;  // ns: residuals so far apart have nothing to do with each other
constexpr double least_count = 20;
constexpr double least_correlation = 0.05;
constexpr double most_factor = 100;

}  // namespace

void ResidualSeries::add(Nanoseconds time, const std::vector<double>& residual) { all_.push_back({time, residual}); }

void ResidualSeries::add_products(std::vector<double>& sums, std::vector<double>& counts) const {
    for (std::size_t i = 0; i < all_.size(); ++i) {
        for (std::size_t lag = 0; lag < sums.size() && i + lag < all_.size(); ++lag) {
            const Stamped& a = all_[i];
            const Stamped& b = all_[i + lag];
            if (b.time - a.time > farthest) break;
            sums[lag] += std::inner_product(a.residual.begin(), a.residual.end(), b.residual.begin(), 0.0);
            counts[lag] += static_cast<double>(a.residual.size());
        }
    }
}

double variance_factor(const std::vector<const ResidualSeries*>& series) {
    std::vector<double> sums(most_lags, 0.0), counts(most_lags, 0.0);
    for (const ResidualSeries* one : series) one->add_products(sums, counts);
    if (counts[0] < least_count) return 1;
    const double variance = sums[0] / counts[0];
    double factor = variance;
    for (std::size_t lag = 1; lag < most_lags && counts[lag] >= least_count; ++lag) {
        const double covariance = sums[lag] / counts[lag];
        if (covariance < least_correlation * variance) break;
        factor += 2 * covariance;
    }
    return std::clamp(factor, 1.0, most_factor);
}

}  // namespace roomfix
