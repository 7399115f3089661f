#include "roomfix/site/load_site.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <sstream>

#include "roomfix/site/read_camera.hpp"
#include "roomfix/site/yaml_reader.hpp"

namespace roomfix {
namespace {

std::optional<Tag> read_tag(YamlReader& reader, const YAML::Node& node, const char* number_key, const std::string& what) {
    constexpr int last = 586;  // of tag36h11
    const auto number = reader.integer(reader.required(node, number_key, what), what + "." + number_key, 0, last);
    const auto size = reader.number(reader.required(node, "size", what), what + ".size", 0.005, 10);
    if (!number || !size) return std::nullopt;
    return Tag{*number, *size};
}

enum class Facing { down, up, wall };

/// The tag's frame in its holder's: on the ceiling and on the floor `yaw` is where its upper edge points, on a wall where its
/// face looks.
Eigen::Isometry3d tag_pose(const Eigen::Vector3d& position, double yaw, Facing facing) {
    const Eigen::Vector3d along(std::cos(yaw), std::sin(yaw), 0);
    const Eigen::Vector3d up = facing == Facing::wall ? Eigen::Vector3d(Eigen::Vector3d::UnitZ()) : along;
    const Eigen::Vector3d out = facing == Facing::wall ? along : Eigen::Vector3d(0, 0, facing == Facing::up ? 1 : -1);
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.linear() << up.cross(out), up, out;
    pose.translation() = position;
    return pose;
}

Receiver read_receiver(YamlReader& reader, const YAML::Node& node, const std::string& what) {
    Receiver receiver;
    if (!reader.map(node, what, {"position", "source", "sigma", "bias_sigma", "scale_sigma"})) return receiver;
    receiver.position = reader.point3(reader.required(node, "position", what), what + ".position").value_or(receiver.position);
    receiver.source = reader.text(node["source"], what + ".source").value_or("");
    receiver.sigma = reader.number(node["sigma"], what + ".sigma", 1e-5, 100).value_or(receiver.sigma);
    receiver.bias_sigma = reader.number(node["bias_sigma"], what + ".bias_sigma", 0, 100).value_or(receiver.bias_sigma);
    receiver.scale_sigma = reader.number(node["scale_sigma"], what + ".scale_sigma", 0, 1).value_or(receiver.scale_sigma);
    return receiver;
}

WheelOdometry read_odometry(YamlReader& reader, const YAML::Node& node, const std::string& what) {
    WheelOdometry odometry;
    if (!reader.map(node, what, {"source", "scale_sigma", "drift_sigma"})) return odometry;
    odometry.source = reader.text(node["source"], what + ".source").value_or("");
    odometry.scale_sigma = reader.number(node["scale_sigma"], what + ".scale_sigma", 0, 1).value_or(odometry.scale_sigma);
    odometry.drift_sigma = reader.number(node["drift_sigma"], what + ".drift_sigma", 0, 10).value_or(odometry.drift_sigma);
    return odometry;
}

/// A tag on the robot's top: its upper edge points forward at yaw 0.
void read_robot_tag(YamlReader& reader, const YAML::Node& node, const std::string& what, SiteRobot& robot) {
    if (!reader.map(node, what, {"id", "size", "position", "yaw_deg"})) return;
    robot.tag = read_tag(reader, node, "id", what);
    const auto position = reader.point3(reader.required(node, "position", what), what + ".position");
    const double yaw = radians(reader.number(node["yaw_deg"], what + ".yaw_deg", -360, 360).value_or(0));
    robot.robot_from_tag = tag_pose(position.value_or(Eigen::Vector3d::Zero()), yaw, Facing::up);
}

void read_robot(YamlReader& reader, const std::string& id, const YAML::Node& node, Site& site) {
    const std::string what = "robots." + id;
    if (!reader.map(node, what, {"shape", "size", "size_sigma", "count", "drive", "odometry", "receiver", "tag"})) return;
    SiteRobot robot;
    robot.id = id;
    const auto kind = reader.text(reader.required(node, "shape", what), what + ".shape");
    const YAML::Node size = reader.required(node, "size", what);
    constexpr double smallest = 0.01;
    constexpr double largest = 50;
    if (kind == "box") {
        if (const auto s = reader.numbers(size, what + ".size (length, width, height)", 3, smallest, largest)) {
            robot.shape = Box{(*s)[0], (*s)[1], (*s)[2]};
        }
    } else if (kind == "cylinder") {
        if (const auto s = reader.numbers(size, what + ".size (diameter, height)", 2, smallest, largest)) {
            robot.shape = Cylinder{(*s)[0], (*s)[1]};
        }
    } else if (kind) {
        reader.error(node["shape"], fmt::format("{}.shape must be box or cylinder, not '{}'", what, *kind));
    }
    robot.size_sigma = reader.number(node["size_sigma"], what + ".size_sigma", 1e-5, 10).value_or(robot.size_sigma);
    if (const auto count = reader.text(node["count"], what + ".count")) {
        robot.many = *count == "many";
        if (*count != "many" && *count != "1") reader.error(node["count"], what + ".count must be 'many' or 1");
    }
    if (const auto drive = reader.text(node["drive"], what + ".drive")) {
        if (*drive == "differential") robot.drive = Drive::differential;
        if (*drive == "holonomic") robot.drive = Drive::holonomic;
        if (*drive != "differential" && *drive != "holonomic" && *drive != "unknown") {
            reader.error(node["drive"], fmt::format("{}.drive must be differential, holonomic or unknown, not '{}'", what, *drive));
        }
    }
    if (node["odometry"].IsDefined()) robot.odometry = read_odometry(reader, node["odometry"], what + ".odometry");
    if (node["receiver"].IsDefined()) robot.receiver = read_receiver(reader, node["receiver"], what + ".receiver");
    if (node["tag"].IsDefined()) read_robot_tag(reader, node["tag"], what + ".tag", robot);
    for (const char* single : {"odometry", "receiver", "tag"}) {
        if (robot.many && node[single].IsDefined()) {
            reader.error(node[single], fmt::format("{}.{}: there are many of this robot: give each robot with a {} an entry of its own", what, single, single));
        }
    }
    site.robots.push_back(robot);
}

void read_beacon(YamlReader& reader, const std::string& id, const YAML::Node& node, Site& site) {
    const std::string what = "beacons." + id;
    if (!reader.map(node, what, {"position", "address"})) return;
    SiteBeacon beacon{id};
    beacon.position = reader.point3(reader.required(node, "position", what), what + ".position").value_or(beacon.position);
    beacon.address = reader.text(node["address"], what + ".address").value_or("");
    for (const SiteBeacon& other : site.beacons) {
        const bool same = !beacon.address.empty() && (beacon.address == other.address || beacon.address == other.id);
        if (same || other.address == id) {
            reader.error(node, fmt::format("{}: beacon {} is called the same: ranges could not be told apart; give each its own address", what, other.id));
        }
    }
    site.beacons.push_back(beacon);
}

void read_tag_landmark(YamlReader& reader, const YAML::Node& node, const std::string& what, const Eigen::Vector3d& position, double yaw, SiteLandmark& landmark,
                       const Site& site) {
    if (const auto tag = read_tag(reader, node, "tag", what)) landmark.kind = *tag;
    const std::string facing = reader.text(node["facing"], what + ".facing").value_or("down");
    if (facing != "down" && facing != "up" && facing != "wall") {
        reader.error(node["facing"], fmt::format("{}.facing must be down (ceiling), wall or up (floor), not '{}'", what, facing));
    }
    landmark.map_from_landmark = tag_pose(position, yaw, facing == "wall" ? Facing::wall : facing == "up" ? Facing::up : Facing::down);
    for (const SiteLandmark& other : site.landmarks) {
        const auto* tag = std::get_if<Tag>(&other.kind);
        if (tag && std::holds_alternative<Tag>(landmark.kind) && tag->number == std::get<Tag>(landmark.kind).number) {
            reader.error(node["tag"], fmt::format("{}.tag: tag {} is landmark {} already: print another number", what, tag->number, other.id));
        }
    }
}

void read_landmark(YamlReader& reader, const std::string& id, const YAML::Node& node, Site& site) {
    const std::string what = "landmarks." + id;
    if (!reader.map(node, what, {"position", "yaw_deg", "legs", "tag", "size", "facing", "beacon", "sigma"})) return;
    SiteLandmark landmark{id};
    const Eigen::Vector3d position = reader.point3(reader.required(node, "position", what), what + ".position").value_or(Eigen::Vector3d::Zero());
    const double yaw = radians(reader.number(node["yaw_deg"], what + ".yaw_deg", -360, 360).value_or(0));
    const bool is_tag = node["tag"].IsDefined();
    if (is_tag == node["legs"].IsDefined()) {
        reader.error(node,
                     fmt::format("{} needs {} legs: [a, b] (three LEDs) or tag: number and size: edge (an AprilTag)", what, is_tag ? "only one of" : "either"));
    } else if (is_tag) {
        read_tag_landmark(reader, node, what, position, yaw, landmark, site);
    } else {
        if (const auto legs = reader.numbers(node["legs"], what + ".legs", 2, 0.001, 10)) landmark.kind = LedTriangle{(*legs)[0], (*legs)[1]};
        landmark.map_from_landmark = Eigen::Translation3d(position) * Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ());
        for (const char* other : {"size", "facing"}) {
            if (node[other].IsDefined()) reader.error(node[other], fmt::format("{}.{} belongs to a tag; three LEDs have legs", what, other));
        }
    }
    landmark.sigma = reader.number(node["sigma"], what + ".sigma", 0, 10).value_or(landmark.sigma);
    landmark.beacon = reader.text(node["beacon"], what + ".beacon").value_or("");
    const bool known = std::any_of(site.beacons.begin(), site.beacons.end(), [&](const auto& b) { return b.id == landmark.beacon; });
    if (!landmark.beacon.empty() && !known) {
        reader.error(node["beacon"], fmt::format("{}.beacon: there is no beacon '{}' under beacons", what, landmark.beacon));
    }
    site.landmarks.push_back(landmark);
}

void read_corner(YamlReader& reader, const std::string& id, const YAML::Node& node, Site& site) {
    const std::string what = "corners." + id;
    if (!reader.map(node, what, {"position", "yaw_deg", "angle_deg", "sigma"})) return;
    SiteCorner corner{id};
    const auto position = reader.point3(reader.required(node, "position", what), what + ".position");
    corner.position = position.value_or(corner.position);
    corner.yaw = radians(reader.number(node["yaw_deg"], what + ".yaw_deg", -360, 360).value_or(0));
    corner.wall_angle = radians(reader.number(node["angle_deg"], what + ".angle_deg", 20, 160).value_or(90));
    corner.sigma = reader.number(node["sigma"], what + ".sigma", 0, 10).value_or(corner.sigma);
    if (position && !(position->z() > 0)) {
        reader.error(node["position"],
                     fmt::format("{}.position: z is {}: a corner under the ceiling is that high above the floor, in metres", what, position->z()));
    }
    site.corners.push_back(corner);
}

void read_installed(YamlReader& reader, const YAML::Node& root, Site& site) {
    for (const auto& [id, node] : reader.named(root["beacons"], "beacons")) read_beacon(reader, id, node, site);
    for (const auto& [id, node] : reader.named(root["landmarks"], "landmarks")) read_landmark(reader, id, node, site);
    for (const auto& [id, node] : reader.named(root["corners"], "corners")) read_corner(reader, id, node, site);
}

void read_outputs(YamlReader& reader, const YAML::Node& node, Site& site) {
    if (!node.IsDefined() || !reader.map(node, "outputs", {"jsonl", "web", "mqtt", "ros2", "history"})) return;
    for (const char* later : {"mqtt", "ros2", "history"}) {
        if (node[later].IsDefined()) reader.warn(node[later], fmt::format("outputs.{} is not available in this version and is ignored", later));
    }
    if (node["jsonl"].IsDefined()) site.outputs.jsonl = reader.text(node["jsonl"], "outputs.jsonl").value_or("");
    if (node["web"].IsDefined() && reader.map(node["web"], "outputs.web", {"host", "port"})) {
        WebOutput web;
        web.host = reader.text(node["web"]["host"], "outputs.web.host").value_or(web.host);
        web.port = reader.integer(node["web"]["port"], "outputs.web.port", 0, 65535).value_or(web.port);
        site.outputs.web = web;
    }
}

void read_place(YamlReader& reader, const YAML::Node& node, Site& site) {
    if (!node.IsDefined() || !reader.map(node, "site", {"name", "ceiling", "temperature", "walls"})) return;
    site.name = reader.text(reader.required(node, "name", "site"), "site.name").value_or("");
    site.ceiling = reader.number(node["ceiling"], "site.ceiling", 0.1, tallest).value_or(0);
    site.temperature = reader.number(node["temperature"], "site.temperature", -60, 80).value_or(site.temperature);
    if (!node["walls"].IsDefined() || !reader.list(node["walls"], "site.walls")) return;
    for (const auto& line : node["walls"]) {
        const std::string what = fmt::format("site.walls[{}]", site.walls.size());
        Polyline polyline;
        if (reader.list(line, what)) {
            for (const auto& point : line) {
                if (const auto p = reader.point2(point, what)) polyline.push_back(*p);
            }
            if (line.size() < 2) reader.error(line, what + " needs two or more points [x, y]");
        }
        site.walls.push_back(polyline);
    }
}

/// A camera of known height looks up to corners.
void check_height(YamlReader& reader, const YAML::Node& node, const SiteCamera& camera, const KnownHeight& known, const Site& site) {
    if (site.corners.empty()) {
        reader.warn(node["height"], fmt::format("cameras.{} has only a height: without 'corners' in the file nothing can place it", camera.id));
    }
    for (const SiteCorner& corner : site.corners) {
        if (corner.position.z() > known.height + 0.01) continue;
        reader.error(node["height"], fmt::format("cameras.{}.height is {} m, but corner {} is {} m high: the camera must be below the ceiling", camera.id,
                                                 known.height, corner.id, corner.position.z()));
    }
}

/// Names that point nowhere, and what the file as a whole lacks.
void check_references(YamlReader& reader, const YAML::Node& root, const Site& site) {
    const auto robot_known = [&](const std::string& id) {
        return std::any_of(site.robots.begin(), site.robots.end(), [&](const auto& r) { return r.id == id; });
    };
    for (const auto& camera : site.cameras) {
        const YAML::Node node = root["cameras"][camera.id];
        std::string robot;
        if (const auto* mount = std::get_if<Mount>(&camera.placement)) robot = mount->robot;
        if (const auto* height = std::get_if<KnownHeight>(&camera.placement)) robot = height->robot;
        if (!robot.empty() && !robot_known(robot)) {
            reader.error(node, fmt::format("cameras.{}: there is no robot '{}' under robots", camera.id, robot));
        }
        if (const auto* height = std::get_if<KnownHeight>(&camera.placement)) check_height(reader, node, camera, *height, site);
        if (const auto* known = std::get_if<KnownPose>(&camera.placement); known && !known->has_covariance) {
            reader.warn(node["pose"], fmt::format("cameras.{}.pose has no covariance: the fixes' uncertainty leaves the calibration out", camera.id));
        }
        if (const auto* mount = std::get_if<Mount>(&camera.placement); mount && !mount->has_covariance) {
            reader.warn(node["mount"], fmt::format("cameras.{}.mount has no covariance: the fixes' uncertainty leaves the mount's tilt out; "
                                                   "'roomfix calibrate mount' measures it",
                                                   camera.id));
        }
    }
}

std::optional<YAML::Node> parse_yaml(std::string_view text, std::vector<Problem>& problems) {
    try {
        return YAML::Load(std::string(text));
    } catch (const YAML::Exception& problem) {
        problems.push_back({problem.mark.line + 1, problem.mark.column + 1, true, "not valid YAML: " + problem.msg});
    } catch (const std::exception& problem) {
        problems.push_back({0, 0, true, std::string("not valid YAML: ") + problem.what()});
    }
    return std::nullopt;
}

void read_site(YamlReader& reader, const YAML::Node& root, Site& site) {
    if (!root.IsMap()) {
        reader.error(root, "a site file is a map that starts with 'roomfix: 1'");
        return;
    }
    reader.map(root, "the site file", {"roomfix", "site", "cameras", "robots", "landmarks", "beacons", "corners", "outputs"});
    const YAML::Node version = reader.required(root, "roomfix", "the site file");
    if (version.IsDefined() && (!version.IsScalar() || version.Scalar() != "1")) {
        reader.error(version, "this is not format 1: write 'roomfix: 1', or use a newer roomfix");
    }
    read_place(reader, reader.required(root, "site", "the site file"), site);
    for (const auto& [id, node] : reader.named(root["cameras"], "cameras")) read_camera(reader, id, node, site);
    for (const auto& [id, node] : reader.named(root["robots"], "robots")) read_robot(reader, id, node, site);
    read_installed(reader, root, site);
    read_outputs(reader, root["outputs"], site);
    if (root["cameras"].IsDefined() && root["cameras"].IsMap()) check_references(reader, root, site);
}

}  // namespace

LoadedSite parse_site(std::string_view text, const std::filesystem::path& folder) {
    LoadedSite loaded;
    loaded.site.folder = folder;
    const auto root = parse_yaml(text, loaded.problems);
    if (!root) return loaded;
    try {
        YamlReader reader(loaded.problems);
        read_site(reader, *root, loaded.site);
    } catch (const YAML::Exception& problem) {  // yaml-cpp throws on some odd node types; they are the file's fault
        loaded.problems.push_back({problem.mark.line + 1, problem.mark.column + 1, true, "cannot be read: " + problem.msg});
    }
    std::stable_sort(loaded.problems.begin(), loaded.problems.end(),
                     [](const Problem& a, const Problem& b) { return a.line != b.line ? a.line < b.line : a.column < b.column; });
    return loaded;
}

LoadedSite inspect_site(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    std::ostringstream text;
    std::error_code failure;
    if (!stream || std::filesystem::is_directory(file, failure) || !(text << stream.rdbuf())) {
        LoadedSite loaded;
        loaded.problems.push_back({0, 0, true, "cannot be read as a site file: check the name and that it is not empty"});
        return loaded;
    }
    return parse_site(text.str(), std::filesystem::absolute(file).parent_path());
}

std::filesystem::path site_file_of(const std::filesystem::path& session) {
    std::error_code failure;
    return std::filesystem::is_directory(session, failure) ? session / "site.yaml" : session;
}

std::string problem_text(const std::filesystem::path& file, const Problem& problem) {
    return fmt::format("{}:{}:{}: {}: {}", file.string(), problem.line, problem.column, problem.fatal ? "error" : "note", problem.message);
}

Result<Site> load_site(const std::filesystem::path& file) {
    auto loaded = inspect_site(file);
    if (loaded.usable()) return std::move(loaded.site);
    std::string all;
    for (const auto& problem : loaded.problems) {
        if (problem.fatal) all += (all.empty() ? "" : "\n") + problem_text(file, problem);
    }
    return Error{all};
}

}  // namespace roomfix
