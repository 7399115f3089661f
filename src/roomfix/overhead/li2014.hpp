// I-H. Li, M.-C. Chen, W.-Y. Wang, S.-F. Su, T.-W. Lai: Mobile Robot Self-Localization System Using Single Webcam Distance
// Measurement Technology in Indoor Environments. Sensors 14 (2014) 2089-2109. As published, as the baseline; misprints are
// corrected where they stand.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "roomfix/base/result.hpp"
#include "roomfix/geometry/view.hpp"
#include "roomfix/imaging/components.hpp"
#include "roomfix/imaging/luma.hpp"

namespace roomfix {

/// Section 4.2: the known rectangle on the floor, clicked once. `near` and `far` are seen from the camera.
struct Li2014Rectangle {
    Eigen::Vector2d left_near, left_far, right_near, right_far;  // px in the image
    double width = 0;                                            // D_N, m
    double length = 0;                                           // along the aisle, m
    double near_distance = 0;                                    // m, camera to the near edge along the aisle
    double left_offset = 0;                                      // m, camera's axis to the left side, left positive
};

/// Where the webcam is and which way its aisle runs: (x_i, y_i) of (15)-(17).
struct Li2014Aisle {
    Eigen::Vector2d camera = Eigen::Vector2d::Zero();      // m, map
    Eigen::Vector2d direction = Eigen::Vector2d::UnitX();  // unit, map: away from the camera
};

/// A rectangle of floor ahead of a calibrated camera, as somebody would have clicked it; and the aisle along its view.
/// Nothing if the camera does not see the floor ahead of it.
std::optional<Li2014Rectangle> li2014_rectangle_ahead(const View& view);
Li2014Aisle li2014_aisle_ahead(const View& view);

struct Li2014Settings {
    int threshold = 25;        // t of (13), grey levels
    double projection = 19.5;  // t_1 of (23): foreground pixels in the fullest row that still count as nothing moving
    int refresh_frames = 50;   // t_s: 5 s at 10 frames a second
};

/// One webcam of the paper.
class Li2014 {
public:
    /// An error if the rectangle cannot give K and h_s (no length, no width, or no perspective between its edges).
    static Result<Li2014> set_up(const CameraModel& model, const Li2014Rectangle& rectangle, const Li2014Aisle& aisle, const Li2014Settings& settings = {});

    /// Section 4.2: the first background is the mean of 150 frames, low-pass filtered.
    void set_background(const std::vector<LumaImage>& frames);

    /// Figure 9: the robot's place on the map (m), or nothing if no blob is found.
    std::optional<Eigen::Vector2d> locate(LumaView frame);

    /// (18): distance along the aisle (m) from the width N (px) between the two lines.
    double ibdms(double line_width) const { return k_ / line_width - h_s_; }
    double ibdms_factor() const { return k_; }    // K, m px
    double ibdms_offset() const { return h_s_; }  // h_s, m
    /// (15)-(22) for one pixel of the floor (px, as in the image).
    std::optional<Eigen::Vector2d> floor_point(const Eigen::Vector2d& r_center) const;

private:
    std::optional<Eigen::Vector2d> find_r_center(LumaView frame);
    void update_background(LumaView frame);

    CameraModel model_;
    Li2014Aisle aisle_;
    Li2014Settings settings_;
    std::array<Eigen::Vector2d, 4> ls_;  // Ls_1 .. Ls_4, px without distortion: left near, left far, right near, right far
    double d_n_ = 0;
    double k_ = 0;
    double h_s_ = 0;
    double left_offset_ = 0;
    LumaImage background_;
    BitMask foreground_;
    BitMask scratch_;
    ComponentFinder labels_;
    int frames_since_refresh_ = 0;
};

}  // namespace roomfix
