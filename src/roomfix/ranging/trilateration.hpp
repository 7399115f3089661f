// A receiver's place on the floor plan from ranges and range differences to beacons.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "roomfix/base/fixed_list.hpp"
#include "roomfix/base/result.hpp"
#include "roomfix/observation/range_noise.hpp"

namespace roomfix {

struct BeaconRange {
    Eigen::Vector3d beacon;  // m, map
    double range = 0;        // m
    double sigma = 0.02;     // m
};

/// |p - b| - |p - a|
struct BeaconDifference {
    Eigen::Vector3d a, b;  // m, map
    double difference = 0;
    double sigma = 0.1;
};

struct TrilaterationSettings {
    bool robust = true;        // late ranges by the model below; false: plain least squares
    LateModel late;            // of ranges and of differences
    double largest_sigma = 5;  // m: beyond, the geometry is called degenerate
    // m: mean of a delay that all ranges of a moment share, as radios have that answer late; estimated with the place, never
    // negative. 0: there is none. It takes three ranges at least.
    double shared_delay = 0;
};

struct TrilaterationPlace {
    Eigen::Vector2d position;    // m, map
    Eigen::Matrix2d covariance;  // m^2
    double weight = 1;           // all weights add up to 1
};

struct Trilateration {
    FixedList<TrilaterationPlace, 4> places;  // the best first; more than one where beacons on a line leave both sides open
    double shared_delay = 0;                  // m, of the best place
    std::vector<double> on_time;              // of the best place: probability per range, then per difference, that it came straight
};

/// `height`: of the receiver above the floor, m. Needs two measurements at least; two ranges give two places. Errors: too few, or
/// a geometry that leaves a direction open (all beacons along one line through the receiver, say).
/// Starts in closed form from every pair or triple of ranges (differences: from a grid around the beacons), refines each start by
/// Gauss-Newton on the mixture of range_noise.hpp, and keeps the most likely places.
Result<Trilateration> trilaterate(std::span<const BeaconRange> ranges, std::span<const BeaconDifference> differences, double height,
                                  const TrilaterationSettings& settings = {});

}  // namespace roomfix
