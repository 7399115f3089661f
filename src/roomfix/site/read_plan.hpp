// The plan of a site: a picture of it from above, by itself or with the map file of a ROS map_server.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "roomfix/site/yaml_reader.hpp"

namespace roomfix {

constexpr int largest_plan = 8192;  // px, of each side

/// What the YAML file of a map_server (ROS 1 and 2) says of its picture.
struct MapFile {
    std::string image;         // as written: relative to the map file
    double resolution = 0.05;  // m per pixel
    Pose2 map_from_plan;       // as of SitePlan
    bool negate = false;       // white is occupied
};

/// The error says what is wrong, with the line. Keys of other programs are passed over.
Result<MapFile> parse_map_file(std::string_view text);
/// The same of a file, which the error names.
Result<MapFile> load_map_file(const std::filesystem::path& file);

/// Does the plan's file say where the picture is, and is not the picture itself?
bool is_map_file(const std::string& file);

/// An error unless the file is there and begins as a PNG or a PGM or PPM picture (P2, P3, P5, P6) of a size that can be shown.
Result<void> check_plan_picture(const std::filesystem::path& file);

/// `plan: map.yaml`, or `plan: {image: plan.png, resolution: 0.05, origin: [x, y, yaw in degrees]}`.
std::optional<SitePlan> read_plan(YamlReader& reader, const YAML::Node& node, const std::filesystem::path& folder);

/// The value of `plan` in a site file.
std::string plan_text(const SitePlan& plan);

}  // namespace roomfix
