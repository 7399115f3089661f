// H.-L. Chou, W.-H. Tsai: A new approach to robot location by house corners. Pattern Recognition 19(6), 1986, pp. 439-451.
// The method as published, in the paper's order and with its symbols; deviations from print are said where they stand.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "roomfix/corner/corner_geometry.hpp"
#include "roomfix/geometry/camera_model.hpp"
#include "roomfix/imaging/luma.hpp"

namespace roomfix {

/// A line a u + b v + c = 0 of the picture: u to the right and v up from the image centre, px. Print has a = 1, which no line along
/// the u axis can have.
struct Chou1986Line {
    double a = 1, b = 0, c = 0;
};

/// The camera against the corner: X and Y axes on the ceiling, Z down along the walls' edge, a right-handed system.
struct Chou1986Parameters {
    double psi = 0, theta = 0, delta = 0;  // pan, tilt, swing, rad
    double x_c = 0, y_c = 0;               // in the unit of Z_c
};

/// Section 2.3: every root of (15), with every half-turn that tan() loses. `f` in px, Z_c > 0.
std::vector<Chou1986Parameters> chou1986_closed_form(const std::array<Chou1986Line, 3>& lines, double f, double z_c);

/// The one candidate that sees the three measured half-lines from inside the room. `rays` are the half-lines of the X, Y and Z axes.
/// Nothing if none does.
std::optional<CornerView> chou1986_view(const CornerRays& rays);

struct Chou1986Settings {
    double edge_threshold = 0.12;  // of the strongest Sobel response: the paper says "a threshold value"
    int most_points = 12000;       // a picture with more edge points gets a higher threshold
    double least_votes = 40;       // of a line (section 3.2)
    std::size_t most_lines = 16;   // with the most votes
    double largest_break = 12;     // px: gaps in a line's points that do not end it
    double end_gap = 20;           // px: check 1, end points that are "very close"
    double crossing_gap = 8;       // px: check 2, crossings that are
    double border_gap = 25;        // px: check 3, an end point "close to the image boundary"
    double point_gap = 2;          // px: edge points of a line lie this close to it
};

class Chou1986 {
public:
    /// The paper knows one focal length and an image centre, and corrects the lens's distortion beforehand (section 4.1): here, of the edge
    /// points.
    explicit Chou1986(const CameraModel& model, const Chou1986Settings& settings = {}) : model_(model), settings_(settings) {}

    /// Section 3: the half-lines of the X, Y and Z axes. Nothing if no three lines pass the checks; `reason`, if given, tells why.
    std::optional<CornerRays> find_lines(LumaView frame, std::string* reason = nullptr) const;

    /// From a picture to the camera's place in units of its distance to the ceiling.
    std::optional<CornerView> locate(LumaView frame, std::string* reason = nullptr) const;

private:
    CameraModel model_;
    Chou1986Settings settings_;
};

}  // namespace roomfix
