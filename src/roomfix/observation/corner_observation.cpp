#include "roomfix/observation/corner_observation.hpp"

#include <cmath>

namespace roomfix {
namespace {

constexpr double lower_if_alone = 0.8;  // that edges are a moulding's lower ones where no others are seen: white plaster hardly shows below a white ceiling
constexpr double measured = 0.015;      // m: the moulding's height is stated about as exactly as this

}  // namespace

CornerObservation at_distance(CornerObservation seen, double scale) {
    seen.view.place /= scale;
    seen.by_intrinsics.bottomRows<2>() /= scale;
    seen.covariance.bottomRows<2>() /= scale;
    seen.covariance.rightCols<2>() /= scale;
    return seen;
}

FixedList<CornerReading, 2> readings_of(const CornerObservation& observed, const std::optional<double>& stated, double distance) {
    FixedList<CornerReading, 2> readings;
    if (stated == 0) {
        if (observed.read) readings.push_back({observed, 0, 1});
        return readings;
    }
    CornerObservation seen = observed;
    seen.covariance.diagonal().head<3>().array() += seen.one_wall_turn;
    seen.covariance.diagonal().tail<2>().array() += seen.one_wall_turn * (1 + seen.view.place.squaredNorm());
    if (!stated) {
        readings.push_back({seen, 0, 1});
        return readings;
    }
    const double moulding = *stated;
    const auto read_at = [&](double depth, double weight) { readings.push_back({at_distance(seen, distance / (distance - depth)), depth, weight}); };
    const double depth = seen.part == MouldingEdge::lower ? moulding : 0;
    const double height = std::abs(seen.other_rise) * (distance - depth);
    const bool is_it = seen.part != MouldingEdge::none_seen && std::abs(height - moulding) < 3 * seen.other_rise_sigma * (distance - depth) + measured;
    if (is_it) {
        read_at(depth, 1);
    } else {
        read_at(moulding, lower_if_alone);
        read_at(0, 1 - lower_if_alone);
    }
    return readings;
}

Matrix5d CornerObservation::covariance_with(const IntrinsicsMatrix& intrinsics) const {
    return covariance + by_intrinsics * intrinsics * by_intrinsics.transpose();
}

}  // namespace roomfix
