// The joints of a tiled floor, found at subpixel level from one known tile on.
#pragma once

#include "roomfix/calibrate/floor.hpp"
#include "roomfix/geometry/pose.hpp"
#include "roomfix/imaging/luma.hpp"

namespace roomfix {

/// A floor of square tiles: one tile's corner is the origin of the grid, its sides are the axes.
struct TileGrid {
    Pose2 map_from_grid;
    double size = 0.3;           // m, from joint to joint
    double size_sigma = 1.5e-4;  // m
};

struct TileGridSettings {
    double reading_sigma = 0.1;     // px, of one place on a joint besides what the picture's noise does to it: joints are not quite straight
    double least_pitch = 7;         // px between joints: closer ones are not told apart
    std::size_t first_joints = 24;  // read in the first round; twice as many in each further one
    std::size_t most_joints = 100000;
};

/// Joints in the picture, starting from a calibration that knows one tile, and farther out round by round as they fix the camera better.
/// Lines are followed only where the next one cannot be taken for them. `sources`: what else is known; it counts in every round. The
/// result has no sightings where the floor shows no joints.
FloorSource find_tile_grid(LumaView picture, const View& about, const TileGrid& grid, const std::vector<FloorSource>& sources,
                           const TileGridSettings& settings = {});

/// The same from a calibration that may leave two places open: the one from which more joints are found counts, and becomes `start`.
FloorSource find_tile_grid_from_either(LumaView picture, const CameraModel& model, const FloorCalibration& known, const TileGrid& grid,
                                       const std::vector<FloorSource>& sources, UncertainPose3& start);

}  // namespace roomfix
