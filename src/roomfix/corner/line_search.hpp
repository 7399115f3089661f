// Long straight lines of a scene in a picture, straight after the lens is undone: a Hough transform in which each edge point votes only
// for lines along its own direction.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "roomfix/geometry/camera_model.hpp"
#include "roomfix/imaging/edge_points.hpp"

namespace roomfix {

struct LineSearchSettings {
    double angle_spread = 7;      // deg: votes of a weak point reach this far to both sides
    double point_distance = 1.3;  // reduced px: points of a line lie this close to it
    double point_angle = 22;      // deg: and run along it this closely
    double least_points = 9;      // of a line
    std::size_t most_lines = 64;
};

/// A line of the picture without its lens, in units of the focal length: normal . p = distance, and which parts of it carry edge points.
struct SceneLine {
    static constexpr int cells = 128;
    Eigen::Vector2d normal = Eigen::Vector2d::UnitX();  // towards the brighter side
    double distance = 0;
    int points = 0;
    double first = 0, cell = 1;                    // cell i covers first + i * cell to first + (i + 1) * cell along (-normal.y, normal.x)
    std::array<std::int16_t, cells + 1> filled{};  // cells with edge points before cell i
    int first_filled = 0, last_filled = 0;         // cells with edge points
    double density = 0;                            // edge points per pixel that they were looked for in, between these two: about 1 for a plain edge

    Eigen::Vector2d along() const { return {-normal.y(), normal.x()}; }
    /// Where it begins and ends.
    std::array<Eigen::Vector2d, 2> ends() const;
    /// Length that carries edge points between two places along the line, and the length itself that lies within the picture's cells.
    double covered(double from, double to) const;
};

class LineSearch {
public:
    explicit LineSearch(const CameraModel& model, const LineSearchSettings& settings = {});

    /// Lines, the one with the most points first. Points of `points` outside the lens model's reach are left out.
    void find(const std::vector<EdgePoint>& points, int reduction, std::vector<SceneLine>& lines);

private:
    struct StraightPoint {
        float x, y;  // px of a picture without lens distortion, from the image centre
        float nx, ny;
        float strength;
        float angle;  // deg, 0..360
    };
    void straighten(const std::vector<EdgePoint>& points);
    template <class Visit>
    void along(const Eigen::Vector2f& normal, const Visit& visit) const;
    void vote(int reduction);
    struct Peak {
        int angle, distance;
        float votes;
    };
    void find_peaks();
    bool fit(const Peak& peak, int reduction, SceneLine& line);

    CameraModel model_;
    LineSearchSettings settings_;
    double focal_;
    float widest_;  // px from the image centre
    int grid_across_ = 0, grid_down_ = 0;
    std::vector<Eigen::Vector2f> straight_;  // where each corner of a 8 x 8 px grid comes to lie; NaN outside the lens model
    static constexpr std::size_t sectors = 72;
    std::vector<StraightPoint> unsorted_;
    std::vector<StraightPoint> points_;  // by sectors of their direction
    std::array<std::size_t, sectors + 1> sector_starts_{};
    std::vector<std::uint8_t> claimed_;  // of the points, by a line
    std::vector<std::size_t> taken_;
    int distances_ = 0;  // cells of the distance axis
    float distance_cell_ = 1;
    std::vector<float> votes_;  // angles x distances
    std::vector<Peak> peaks_;
    double least_ = 0;  // points of a line
};

}  // namespace roomfix
