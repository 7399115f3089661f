#include "roomfix/site/read_model.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>

#include "roomfix/site/body_parts.hpp"
#include "roomfix/site/learned_body.hpp"
#include "roomfix/site/mesh_parts.hpp"
#include "roomfix/site/read_mesh.hpp"
#include "roomfix/site/read_urdf.hpp"

namespace roomfix {
namespace {

namespace fs = std::filesystem;

constexpr double shortest_model = 0.02;  // m, of the longest side
constexpr double longest_model = 10;     // m
constexpr double thinnest_model = 0.01;  // m, of any side, as for parts

/// A unit in which a robot of this length would have an ordinary size.
std::string unit_that_fits(double length) {
    struct Unit {
        double metres;
        const char* words;
    };
    for (const auto& [metres, words] : {Unit{1, "metres: leave model_scale out"}, Unit{0.001, "millimetres: model_scale: 0.001"},
                                        Unit{0.01, "centimetres: model_scale: 0.01"}, Unit{0.0254, "inches: model_scale: 0.0254"}}) {
        if (length * metres >= 0.1 && length * metres <= 4) return fmt::format("perhaps it is in {}", words);
    }
    return "give metres per unit as model_scale";
}

/// Size and place, before anything is made of the mesh. `scale`: by which it was multiplied already.
Result<void> check_size(const fs::path& file, const TriangleMesh& mesh, double scale) {
    const Eigen::AlignedBox3d box = box_of(mesh);
    const Eigen::Vector3d size = box.sizes();
    const double length = size.maxCoeff();
    if (!(length >= shortest_model && length <= longest_model)) {
        return Error{fmt::format("{}: the model is {:.4g} x {:.4g} x {:.4g} m, a robot's longest side has {} to {} m: {}", file.string(), size.x(), size.y(),
                                 size.z(), shortest_model, longest_model, unit_that_fits(length / scale))};
    }
    if (size.minCoeff() < thinnest_model) {
        return Error{fmt::format("{}: the model is flat ({:.4g} x {:.4g} x {:.4g} m): a robot is at least {} m long, wide and high", file.string(), size.x(),
                                 size.y(), size.z(), thinnest_model)};
    }
    const Eigen::Vector2d away = box.center().head<2>();
    if (away.norm() > length) {
        return Error{fmt::format("{}: the model's middle is {:.2f} m away from its origin, ({:.2f}, {:.2f}) m: move it to where the robot's position is meant",
                                 file.string(), away.norm(), away.x(), away.y())};
    }
    return {};
}

/// Whatever height the file gives it: the lowest point is on the floor.
void stand_on_floor(TriangleMesh& mesh) {
    const double lowest = box_of(mesh).min().z();
    for (Eigen::Vector3d& p : mesh.corners) p.z() -= lowest;
}

Result<TriangleMesh> scaled_mesh(const fs::path& file, double scale) {
    auto mesh = read_mesh(file, UpAxis::as_stated);
    if (!mesh) return mesh;
    for (Eigen::Vector3d& p : mesh->corners) p *= scale;
    stand_on_floor(*mesh);
    return mesh;
}

/// The URDF's triangles. A base_footprint says where the floor is: the robot has to touch it, or nearly so.
Result<TriangleMesh> urdf_mesh(const fs::path& file) {
    constexpr double above = 0.05;  // m
    constexpr double below = 0.02;  // m
    auto model = read_urdf(file);
    if (!model) return model.error();
    const double lowest = box_of(model->mesh).min().z();
    if (model->stands_on_floor && (lowest > above || lowest < -below)) {
        return Error{
            fmt::format("{}: the robot's lowest point is {:.2f} m {} the floor, z = 0 of base_footprint: {} everything by that much in the joint below "
                        "base_footprint, or give it the wheels that it stands on",
                        file.string(), std::abs(lowest), lowest > 0 ? "above" : "below", lowest > 0 ? "lower" : "raise")};
    }
    if (!model->stands_on_floor) stand_on_floor(model->mesh);
    return std::move(model->mesh);
}

void read_learned(YamlReader& reader, const YAML::Node& node, const std::string& what, const std::string& name, const fs::path& file, SiteRobot& robot) {
    auto body = read_learned_body(file);
    if (!body) return reader.error(node, fmt::format("{}.model: {}", what, body.error().message));
    robot.learned_body = name;
    robot.parts = body->parts;
    robot.shape = box_around(robot.parts);
    robot.size_sigma = body->size_sigma;
    robot.learned = std::make_shared<const LearnedBody>(std::move(*body));
}

}  // namespace

void read_model(YamlReader& reader, const YAML::Node& node, const YAML::Node& scale_node, const std::string& what, const Site& site, SiteRobot& robot) {
    const auto name = reader.text(node, what + ".model");
    const double scale = reader.number(scale_node, what + ".model_scale (metres per unit)", 1e-6, 1e6).value_or(1);
    if (!name) return;
    const fs::path file = resolved_path(site, *name);
    const bool learned = file.extension() == learned_body_ending;
    const bool urdf = file.extension() == ".urdf";
    if (!learned && !urdf && !is_mesh_file(file)) {
        return reader.error(
            node, fmt::format("{}.model: '{}' is no model: name a body file (*{}) that 'roomfix calibrate robot' learned, a URDF (*.urdf; a xacro "
                              "file has to become one first), or a mesh (*.stl, *.obj, *.dae, *.ply, *.gltf, *.glb); or describe the robot by 'parts'",
                              what, *name, learned_body_ending));
    }
    if (scale_node.IsDefined() && (learned || urdf)) {
        return reader.error(scale_node, fmt::format("{}.model_scale belongs to a mesh: {}", what,
                                                    urdf ? "a URDF is in metres, and its meshes have a 'scale' of their own" : "a body file is in metres"));
    }
    if (learned) return read_learned(reader, node, what, *name, file, robot);
    auto mesh = urdf ? urdf_mesh(file) : scaled_mesh(file, scale);
    if (!mesh) return reader.error(node, fmt::format("{}.model: {}", what, mesh.error().message));
    if (const auto sane = check_size(file, *mesh, scale); !sane) return reader.error(node, fmt::format("{}.model: {}", what, sane.error().message));
    robot.model = *name;
    robot.model_scale = scale;
    robot.parts = mesh_parts(*mesh);
    robot.shape = box_around(robot.parts);
}

}  // namespace roomfix
