// Random vectors, drawn in an order that is stated: a compiler may evaluate the arguments of a call in any order, so that Eigen::Vector2d(random.normal(),
// random.normal()) would make another world of the same seed with every compiler. The last number is drawn first.
#pragma once

#include <Eigen/Core>

#include "roomfix/base/random.hpp"

namespace roomfix {

/// Independent normal numbers with the given standard deviations.
template <int n>
Eigen::Matrix<double, n, 1> normal_vector(Random& random, const Eigen::Matrix<double, n, 1>& sigma) {
    Eigen::Matrix<double, n, 1> drawn;
    for (int i = n - 1; i >= 0; --i) drawn[i] = random.normal(sigma[i]);
    return drawn;
}

inline Eigen::Vector2d normal2(Random& random, double sigma = 1) { return normal_vector<2>(random, Eigen::Vector2d::Constant(sigma)); }
inline Eigen::Vector3d normal3(Random& random, double sigma = 1) { return normal_vector<3>(random, Eigen::Vector3d::Constant(sigma)); }

/// Independent numbers, each evenly spread between its two bounds.
template <int n>
Eigen::Matrix<double, n, 1> uniform_vector(Random& random, const Eigen::Matrix<double, n, 1>& low, const Eigen::Matrix<double, n, 1>& high) {
    Eigen::Matrix<double, n, 1> drawn;
    for (int i = n - 1; i >= 0; --i) drawn[i] = random.uniform(low[i], high[i]);
    return drawn;
}

inline Eigen::Vector2d uniform2(Random& random, const Eigen::Vector2d& low, const Eigen::Vector2d& high) { return uniform_vector<2>(random, low, high); }
inline Eigen::Vector3d uniform3(Random& random, const Eigen::Vector3d& low, const Eigen::Vector3d& high) { return uniform_vector<3>(random, low, high); }

}  // namespace roomfix
