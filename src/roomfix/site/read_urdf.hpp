// Robot descriptions in URDF as triangles.
#pragma once

#include <filesystem>
#include <string>

#include "roomfix/base/result.hpp"
#include "roomfix/geometry/triangle_mesh.hpp"

namespace roomfix {

/// The whole robot with all joints at zero.
struct UrdfModel {
    TriangleMesh mesh;             // m, in the frame of `origin`
    std::string origin;            // the link that is the robot's origin: base_footprint, else base_link, else the root
    bool stands_on_floor = false;  // z = 0 is the floor, because there is a base_footprint (ROS REP 120)
};

/// What is visible of all links; of a link without visual geometry, what collides. Meshes are looked for beside the URDF, those
/// of package://NAME/... in all folders above it. An error names the file and, where there is one, the line.
Result<UrdfModel> read_urdf(const std::filesystem::path& file);
Result<UrdfModel> parse_urdf(const std::string& text, const std::filesystem::path& file);

}  // namespace roomfix
