// What was seen in a picture, as it is drawn into it: on the page, and by `fix --overlay`.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <vector>

namespace roomfix {

/// A straight piece, px.
struct DrawnLine {
    Eigen::Vector2f from, to;
};

/// A robot's outline.
struct DrawnOutline {
    std::string robot;
    std::vector<Eigen::Vector2f> points;         // px, closed polygon
    double support = 0;                          // part of it that the picture confirms, 0..1
    std::string label;                           // above it
    std::optional<Eigen::Vector2f> foot, ahead;  // px: its place on the floor, and a point of the floor before it; nothing where that is out of sight
};

/// A landmark or a tag.
struct DrawnLandmark {
    std::string id;  // empty: none of the site, or not known which
    std::vector<Eigen::Vector2f> points;
    std::string label{};  // above it, where it has no id
};

struct DrawnCorner {
    std::string id;  // empty while it is open which one it is
    Eigen::Vector2f pixel = Eigen::Vector2f::Zero();
    std::array<DrawnLine, 3> edges;  // the one between the walls last
};

/// Everything in px of the frame; the centre of its first pixel is at 0, 0.
struct Drawing {
    std::vector<DrawnOutline> outlines;
    std::vector<DrawnLandmark> landmarks;
    std::vector<Eigen::Vector2f> rejected_spots;  // that are no landmark
    std::vector<std::array<int, 4>> lamps;        // left, top, right, bottom: bright things that are no landmark either
    std::optional<DrawnCorner> corner;
    std::vector<DrawnLine> rejected_lines;  // that are no edge of a corner
    // What the camera looks for, whether it sees some or not:
    bool shows_landmarks = false;
    bool shows_lamps = false;
    bool shows_corners = false;
    std::string caption;  // along the lower edge: the place that was found, or why there is none
};

}  // namespace roomfix
