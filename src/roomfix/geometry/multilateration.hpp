// Where distances to known points meet, in closed form.
#pragma once

#include <Eigen/Core>
#include <span>

#include "roomfix/base/fixed_list.hpp"

namespace roomfix {

/// A circle on the floor plan.
struct Circle {
    Eigen::Vector2d centre;  // m
    double radius = 0;       // m
};

/// The points nearest to two or more circles in the sense of the linearised equations: one if the centres spread over the plane,
/// two that mirror each other if they lie (nearly) on a line, none for fewer than two different centres.
/// Source: differences of the circles' equations are linear in x, y.
FixedList<Eigen::Vector2d, 2> meeting_points(std::span<const Circle> circles);

}  // namespace roomfix
