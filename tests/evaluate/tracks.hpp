// Ways and fixes that are easy to reckon with: all drive 1 m/s along x, each at its own y, ten moments a second.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "roomfix/evaluate/moments.hpp"

namespace roomfix {

inline Fix ok_fix(double t, const std::string& name, double x, double y, double sigma = 0.02) {
    Fix fix;
    fix.time = from_seconds(t);
    fix.robot = name;
    fix.status = FixStatus::ok;
    fix.pose = {x, y, 0};
    fix.covariance = Eigen::Vector3d(sigma * sigma, sigma * sigma, 1e-4).asDiagonal();
    fix.sources = {"hall"};
    return fix;
}

inline void drive(Truth& truth, const std::string& name, double y, int moments = 100) {
    for (int i = 0; i < moments; ++i) truth[name].push_back({from_seconds(0.1 * i), {0.1 * i, y, 0}});
}

/// r1 at y = 0 and r2 at y = 3.
inline Truth side_by_side(int moments = 100) {
    Truth truth;
    drive(truth, "r1", 0, moments);
    drive(truth, "r2", 3, moments);
    return truth;
}

/// Fixes on a way from moment `begin` to before `end`, in the order of time if `fixes` is sorted afterwards.
inline void follow(std::vector<Fix>& fixes, const std::string& name, double y, int begin = 0, int end = 100) {
    for (int i = begin; i < end; ++i) fixes.push_back(ok_fix(0.1 * i, name, 0.1 * i, y));
    std::stable_sort(fixes.begin(), fixes.end(), [](const Fix& a, const Fix& b) { return a.time < b.time; });
}

inline Moments moments_with(const std::vector<Fix>& fixes, const Truth& truth, double cutoff = 1) {
    return moments_of(fixes, truth, times_of(truth), cutoff, 0.05);
}

/// r1 and r2 are found exactly, and their names swap half way.
inline std::vector<Fix> swapped_halves() {
    std::vector<Fix> fixes;
    follow(fixes, "r1", 0, 0, 50);
    follow(fixes, "r2", 3, 0, 50);
    follow(fixes, "r1", 3, 50, 100);
    follow(fixes, "r2", 0, 50, 100);
    return fixes;
}

}  // namespace roomfix
