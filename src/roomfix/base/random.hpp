// Seeded random numbers that give the same sequence on every machine (the standard library's distributions do not).
#pragma once

#include <cstdint>

namespace roomfix {

/// The finaliser of SplitMix64 (Steele, Lea, Flood 2014): a good 64-bit hash of a 64-bit number.
constexpr std::uint64_t mix64(std::uint64_t z) {
    z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27U)) * 0x94d049bb133111ebULL;
    return z ^ (z >> 31U);
}

/// The standard normal deviate below which a fraction p of the distribution lies; 0 < p < 1.
/// Rational approximation by P. J. Acklam, relative error below 1.2e-9.
double normal_quantile(double p);

/// A sequence of random numbers that the seed decides.
class Random {
public:
    explicit Random(std::uint64_t seed) : state_(mix64(seed ^ 0x9e3779b97f4a7c15ULL)) {}

    std::uint64_t bits() { return mix64(state_ += 0x9e3779b97f4a7c15ULL); }
    /// Strictly between 0 and 1.
    double uniform() { return (static_cast<double>(bits() >> 12U) + 0.5) * 0x1p-52; }
    double uniform(double low, double high) { return low + (high - low) * uniform(); }
    double normal(double sigma = 1.0) { return sigma * normal_quantile(uniform()); }
    /// 0 .. count-1
    int index(int count) { return static_cast<int>(uniform() * count); }

private:
    std::uint64_t state_;
};

}  // namespace roomfix
