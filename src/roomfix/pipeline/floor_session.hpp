// What one picture of a fixed camera tells about where the camera is: tags and tiles on the floor, and a room's corner.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "roomfix/calibrate/floor.hpp"
#include "roomfix/calibrate/tile_grid.hpp"
#include "roomfix/imaging/luma.hpp"
#include "roomfix/site/site.hpp"

namespace roomfix {

struct FloorOptions {
    std::vector<FloorPoint> points;     // clicked
    double click_sigma = 0.5;           // px, of each coordinate
    std::vector<Eigen::Vector2d> tile;  // px, four corners of one tile, counter-clockwise seen from above
    TileGrid grid;                      // where that tile is: its first corner is the grid's origin, its first side the x axis
    bool follow_joints = true;          // from the tile on, over the whole floor
    std::string corner;                 // of the site, that the camera sees; empty: none
    std::optional<double> height;       // m, of the camera: needed with a corner
    double height_sigma = 0.005;        // m
};

struct FloorSession {
    FloorCalibration calibration;
    std::vector<FloorSource> sources;
};

/// Collects all that is given and found, and calibrates with it. The site's tags that lie on the floor are looked for, too. Errors say what
/// is missing or contradicts itself.
Result<FloorSession> calibrate_floor_from(const Site& site, const SiteCamera& camera, LumaView picture, const FloorOptions& options);

}  // namespace roomfix
