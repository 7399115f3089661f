// How a robot's senses err, found by trying: which noise makes what they said likeliest?
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "roomfix/estimate/sense_noise.hpp"

namespace roomfix {

/// What was sensed, and what is stated of it: m, rad.
struct SensedKinds {
    bool ranges = false, sighted_ranges = false, bearings = false, wheels = false;
    double range_sigma = 0.02, sighted_sigma = 0.05, bearing_sigma = 0.01;
};

/// Looks for the noise under which all that was sensed is most likely, one number after the other: it is doubled, halved, taken away, ...
class NoiseSearch {
public:
    /// Log density of all that was sensed, as a tracker that takes this noise for granted foresaw it.
    using Evidence = std::function<double(const SenseNoise& noise)>;
    /// `before`: what was learned earlier; it is doubted, but not forgotten.
    NoiseSearch(const SensedKinds& kinds, const std::optional<SenseNoise>& before, const Evidence& evidence);

    struct Result {
        SenseNoise noise;
        double log_density = 0;  // with what is known of such noise beforehand
    };
    Result best(const SenseNoise& start) const;
    /// Few observations tell little of the noise: each standard deviation becomes the root of its mean square over what it may be (a normal distribution of
    /// its logarithm, by the curvature at the best).
    SenseNoise widened(const Result& best) const;
    double log_density(const SenseNoise& noise) const;

private:
    SensedKinds kinds_;
    std::optional<SenseNoise> before_;
    const Evidence& evidence_;
};

}  // namespace roomfix
