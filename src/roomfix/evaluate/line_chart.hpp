// Curves over a common axis as an SVG picture.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace roomfix {

struct Curve {
    std::string name;
    std::vector<Eigen::Vector2d> points;
    bool dashed = false;
};

struct LineChart {
    std::string title;
    std::string x_label, y_label;
    std::vector<Curve> curves;
    bool logarithmic = false;  // y axis
};

/// The chart as the text of an SVG file, 760 x 460 px. Curves without points are left out; axes end at round numbers.
std::string svg_of(const LineChart& chart);

}  // namespace roomfix
