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

/// normal_quantile() of a fraction below 0.02425.
double normal_tail_quantile(double p);

/// The standard normal deviate below which a fraction p of the distribution lies; 0 < p < 1.
/// Rational approximation by P. J. Acklam, relative error below 1.2e-9.
inline double normal_quantile(double p) {
    constexpr double a[] = {-3.969683028665376e+01, 2.209460984245205e+02,  -2.759285104469687e+02,
                            1.383577518672690e+02,  -3.066479806614716e+01, 2.506628277459239e+00};
    constexpr double b[] = {-5.447609879822406e+01, 1.615858368580409e+02, -1.556989798598866e+02, 6.680131188771972e+01, -1.328068155288572e+01};
    constexpr double low = 0.02425;
    if (p < low) return normal_tail_quantile(p);
    if (p > 1 - low) return -normal_tail_quantile(1 - p);
    const double q = p - 0.5;
    const double r = q * q;
    return (((((a[0] * r + a[1]) * r + a[2]) * r + a[3]) * r + a[4]) * r + a[5]) * q / (((((b[0] * r + b[1]) * r + b[2]) * r + b[3]) * r + b[4]) * r + 1);
}

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
