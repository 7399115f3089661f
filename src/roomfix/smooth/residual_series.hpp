// What is left over of one source after smoothing: is its noise as small and as short as it says?
#pragma once

#include <vector>

#include "roomfix/base/time.hpp"

namespace roomfix {

/// Whitened residuals in the order of their times, all of one length.
class ResidualSeries {
public:
    void add(Nanoseconds time, const std::vector<double>& residual);

    /// Adds, for each lag of so many observations, the products of residuals that far apart, and their number.
    void add_products(std::vector<double>& sums, std::vector<double>& counts) const;

private:
    struct Stamped {
        Nanoseconds time;
        std::vector<double> residual;
    };
    std::vector<Stamped> all_;
};

/// By which factor the variances of white noise must grow, so that an average over it is as uncertain as one over these residuals:
/// variance and all correlations in time together. At least 1, and 1 for fewer than 20 residuals.
/// Source: integrated autocorrelation with the initial positive sequence (Geyer 1992).
double variance_factor(const std::vector<const ResidualSeries*>& series);

}  // namespace roomfix
