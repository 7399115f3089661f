// Which three of many bright spots are a landmark's LEDs.
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

namespace roomfix {

/// A right triangle to look for, as its LEDs lie in the plane of the ceiling.
struct TriangleShape {
    double a = 0, b = 0;   // m, legs
    double tolerance = 0;  // m, of each side: noise of the spots' places
    double stretch = 0;    // relative: what an unknown tilt of the camera does to lengths
};

struct TriangleMatch {
    std::array<int, 3> spots;  // right angle, end of leg a, end of leg b
    double misfit = 0;         // largest side error / its tolerance, 0..1
};

/// All matches among `places` (m, robot frame, seen in the plane of the landmark): three sides within tolerance, and the right
/// handedness: from leg a to leg b counter-clockwise as the map is. Appends to `matches`.
void find_triangles(std::span<const Eigen::Vector2d> places, const TriangleShape& shape, std::vector<TriangleMatch>& matches);

}  // namespace roomfix
