// Kim, An, Lee 2011, "Localization of Mobile Robot Based on Fusion of Artificial Landmark and RF TDOA Distance under Indoor Sensor
// Network", as published: the baseline that ours is compared with. Deviations from print are explained where they stand.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "roomfix/geometry/pose.hpp"
#include "roomfix/imaging/luma.hpp"
#include "roomfix/site/site.hpp"

namespace roomfix {

struct Kim2011Settings {
    int threshold = 150;            // grey level above which the binary picture is 255
    int smallest = 2;               // px: smaller labelled areas are noise
    int largest = 40;               // px: larger ones are lamps
    int segment = 24;               // px: edge of the pieces that a lamp's area is split into, Fig. 12
    int expansion = 6;              // px that the window around a lamp's piece is expanded by, Fig. 10
    double shape_tolerance = 0.15;  // relative, of the triangle's side ratios
    double longest = 60;            // px: three spots farther apart are no landmark
    double rule = 0.10;             // m, Kim (7)
    double edge = 0.7;              // of the half picture: farther out dist_c2s is interpolated ...
    double edge_threshold = 0.05;   // ... if it differs from the range's by this part
};

struct Kim2011Fix {
    Pose2 pose;
    bool used_range = false;  // s = s_TDOA, not s_LAND
};

class Kim2011 {
public:
    /// `mount` gives only the picture's handedness: which way its axes point on the robot. The camera is taken to sit over the
    /// robot's centre and to look straight up.
    Kim2011(const SiteLandmark& landmark, const Mount& mount, const Kim2011Settings& settings = {});

    /// `distance`: d_k from the node at the landmark to the receiver, m; `height`: h, of the node above the receiver, m. Without a
    /// distance s_LAND is used. Nothing, with the reason, where no landmark is found.
    std::optional<Kim2011Fix> locate(LumaView frame, std::optional<double> distance, double height, std::string* reason = nullptr);

private:
    struct Area {
        int count = 0;
        Eigen::Vector2d sum = Eigen::Vector2d::Zero();
        std::vector<std::pair<int, int>> pixels;
    };
    struct Window {
        int left, top, right, bottom;
    };
    void label(LumaView frame);
    std::vector<Window> lamp_windows() const;
    std::vector<Eigen::Vector2d> candidates() const;
    std::optional<std::array<Eigen::Vector2d, 3>> landmark_among(const std::vector<Eigen::Vector2d>& centres) const;

    LedTriangle triangle_;
    Eigen::Isometry3d map_from_landmark_;
    Eigen::Matrix3d robot_from_camera_;
    Kim2011Settings settings_;
    std::vector<Area> areas_;
    std::vector<char> open_;  // pixels still to be labelled
};

}  // namespace roomfix
