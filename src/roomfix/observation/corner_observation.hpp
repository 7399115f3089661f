// What a camera says about a room's corner that it sees.
#pragma once

#include <Eigen/Core>
#include <array>
#include <numbers>
#include <optional>

#include "roomfix/base/fixed_list.hpp"
#include "roomfix/geometry/camera_model.hpp"
#include "roomfix/observation/time_error.hpp"

namespace roomfix {

using Matrix5d = Eigen::Matrix<double, 5, 5>;
using Vector5d = Eigen::Matrix<double, 5, 1>;

/// Derivatives of a corner's five unknowns by the intrinsics.
using CornerByIntrinsics = Eigen::Matrix<double, 5, most_intrinsics>;

/// The camera against a corner, up to scale: all that one picture of a corner can tell. Corner frame: origin where the two walls meet
/// the ceiling, x along the corner's x edge, z up, y to the left of x.
struct CornerView {
    Eigen::Matrix3d corner_from_camera = Eigen::Matrix3d::Identity();
    Eigen::Vector2d place = Eigen::Vector2d::Zero();  // the camera is at Z_c (place.x, place.y, -1), Z_c its distance to the ceiling
};

/// The three edges of a corner, in this order everywhere.
enum CornerEdge { x_edge = 0, y_edge = 1, wall_edge = 2 };

/// One edge of the corner in the picture.
struct EdgeSighting {
    std::array<Eigen::Vector2f, 2> ends = {Eigen::Vector2f::Zero(), Eigen::Vector2f::Zero()};  // px: at the corner, and as far as it is seen
    float visible = 0;                                                                         // px of it inside the picture
    float seen = 0;                                                                            // px of that which the picture confirms
};

/// Which corner of a moulding's was read: where the edge between the walls ends, below it, or where the walls meet the ceiling.
enum class MouldingEdge { none_seen, lower, upper };

struct CornerObservation {
    CornerView view;
    TimeError time_error;
    double wall_angle = std::numbers::pi / 2;  // rad, between the two walls, inside the room
    // Rotation about the corner's x, y, z (rad): true = Exp(d) * corner_from_camera; then place. As if the intrinsics were exact.
    Matrix5d covariance = Matrix5d::Identity();
    CornerByIntrinsics by_intrinsics = CornerByIntrinsics::Zero();  // had they been others, the view would be another, too
    double weight = 1;                                              // among all that one picture may show
    Eigen::Vector2f pixel = Eigen::Vector2f::Zero();
    std::array<EdgeSighting, 3> edges;
    // A moulding's two corners are two observations of one sighting, which exclude each other. Each tells how far above it the other one lies, in its
    // ceiling distances.
    int sighting = 0;
    MouldingEdge part = MouldingEdge::none_seen;
    double other_rise = 0, other_rise_sigma = 0;
    bool read = true;          // false of the corner that was not read itself
    double one_wall_turn = 0;  // rad^2: had the moulding been along one wall only, the three edges would not meet, and the view be turned

    /// With what is not known of the intrinsics.
    Matrix5d covariance_with(const IntrinsicsMatrix& intrinsics) const;
};

/// The same picture of a corner that is `scale` times as far above the camera.
CornerObservation at_distance(CornerObservation seen, double scale);

/// What was read, as a picture of the site's corner.
struct CornerReading {
    CornerObservation seen;
    double depth = 0;   // m: of what was read below the site's corner
    double weight = 1;  // among the readings
};
/// What was read may be either corner of a moulding whose height the site states (m). Where it states nothing, its corner is what was read; where it states
/// that there is none (0), nothing beside the edges counts. `distance`: from the camera up to the site's corner, m; more than the moulding's height.
FixedList<CornerReading, 2> readings_of(const CornerObservation& seen, const std::optional<double>& moulding, double distance);

}  // namespace roomfix
