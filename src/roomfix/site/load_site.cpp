#include "roomfix/site/load_site.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <sstream>

#include "roomfix/base/csv.hpp"
#include "roomfix/base/printable.hpp"
#include "roomfix/site/read_camera.hpp"
#include "roomfix/site/read_installed.hpp"
#include "roomfix/site/read_outputs.hpp"
#include "roomfix/site/read_plan.hpp"
#include "roomfix/site/read_robot.hpp"
#include "roomfix/site/read_zone.hpp"
#include "roomfix/site/yaml_reader.hpp"

namespace roomfix {
namespace {

void read_place(YamlReader& reader, const YAML::Node& node, Site& site) {
    if (!node.IsDefined() || !reader.map(node, "site", {"name", "ceiling", "temperature", "walls", "lost"})) return;
    site.name = reader.text(reader.required(node, "name", "site"), "site.name").value_or("");
    site.ceiling = reader.number(node["ceiling"], "site.ceiling", 0.1, tallest).value_or(0);
    site.temperature = reader.number(node["temperature"], "site.temperature", -60, 80).value_or(site.temperature);
    site.lost = reader.number(node["lost"], "site.lost", 1e-3, 1000).value_or(site.lost);
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

/// A camera of known height is placed by the corners and tags that it sees.
void check_height(YamlReader& reader, const YAML::Node& node, const SiteCamera& camera, const KnownHeight& known, const Site& site) {
    const auto is_tag = [](const SiteLandmark& l) { return std::holds_alternative<Tag>(l.kind); };
    if (site.corners.empty() && std::none_of(site.landmarks.begin(), site.landmarks.end(), is_tag)) {
        reader.warn(node["height"], fmt::format("cameras.{} has only a height: without 'corners' or tags under 'landmarks' nothing can place it", camera.id));
    }
    for (const SiteCorner& corner : site.corners) {
        if (corner.lower_edge() > known.height + 0.01) continue;
        reader.error(node["height"],
                     fmt::format("cameras.{}.height is {} m, but corner {} is {} m high: the camera must be below the ceiling and its mouldings", camera.id,
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

/// Readings by MQTT need a broker.
void check_topics(YamlReader& reader, const YAML::Node& root, const Site& site) {
    if (site.outputs.mqtt) return;
    for (const SiteRobot& robot : site.robots) {
        const auto by_topic = [](const std::string& source) { return source.starts_with("mqtt:"); };
        const bool some = std::any_of(robot.receivers.begin(), robot.receivers.end(), [&](const Receiver& r) { return by_topic(r.source); });
        if (!some && !(robot.odometry && by_topic(robot.odometry->source)) && !(robot.detector && by_topic(robot.detector->source))) continue;
        reader.error(root["robots"][robot.id], fmt::format("robots.{} has a source 'mqtt:...', but outputs.mqtt does not say where the broker is", robot.id));
    }
}

/// "/r1/odom": words of letters, digits and single underscores with slashes before them.
bool is_ros_topic_name(std::string_view name) {
    const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
    const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; };
    for (std::size_t i = 0; i < name.size(); ++i) {
        const char before = i == 0 ? '\0' : name[i - 1], c = name[i];
        const bool fits = c == '/' ? before != '/' && i + 1 < name.size() : is_letter(c) || (is_digit(c) && before != '/');
        if (!fits || (c == '_' && before == '_')) return false;
    }
    return name.starts_with('/');
}

/// A ROS 2 topic reports one robot's wheels.
void check_ros_topics(YamlReader& reader, const YAML::Node& root, const Site& site) {
    const std::string scheme = "ros2:";
    std::map<std::string, std::string> robots;  // by their topics
    for (const SiteRobot& robot : site.robots) {
        const auto complain = [&](const std::string& what) { reader.error(root["robots"][robot.id], fmt::format("robots.{} {}", robot.id, what)); };
        const bool heard = std::any_of(robot.receivers.begin(), robot.receivers.end(), [&](const Receiver& r) { return r.source.starts_with(scheme); });
        if (heard || (robot.detector && robot.detector->source.starts_with(scheme))) {
            complain("has a source 'ros2:...' that is not its odometry's: ROS 2 topics are read for wheels only (nav_msgs/msg/Odometry)");
        }
        if (!robot.odometry || !robot.odometry->source.starts_with(scheme)) continue;
        const std::string topic = robot.odometry->source.substr(scheme.size());
        if (!is_ros_topic_name(topic)) complain(fmt::format("has the odometry source 'ros2:{}': write the whole name of a topic, as in ros2:/r1/odom", topic));
        const auto [other, is_first] = robots.try_emplace(topic, robot.id);
        if (!is_first) complain(fmt::format("has the same odometry source as {}: messages on {} do not say whose wheels they are of", other->second, topic));
    }
}

/// Nobody could show, send or store a name in another encoding. (YAML itself allows UTF-16, which begins with a mark.)
bool is_utf8(std::string_view text, std::vector<Problem>& problems) {
    if (text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF")) return true;
    const auto wrong = first_that_is_not_utf8(text);
    if (!wrong) return true;
    const std::string_view before = text.substr(0, *wrong);
    const auto line = std::count(before.begin(), before.end(), '\n') + 1;
    const auto column = *wrong - (before.rfind('\n') + 1) + 1;
    problems.push_back({static_cast<int>(line), static_cast<int>(column), true, "a byte that is not UTF-8: save the file as UTF-8"});
    return false;
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
    reader.map(root, "the site file", {"roomfix", "site", "cameras", "robots", "landmarks", "beacons", "corners", "zones", "plan", "outputs"});
    const YAML::Node version = reader.required(root, "roomfix", "the site file");
    if (version.IsDefined() && (!version.IsScalar() || version.Scalar() != "1")) {
        reader.error(version, "this is not format 1: write 'roomfix: 1', or use a newer roomfix");
    }
    read_place(reader, reader.required(root, "site", "the site file"), site);
    for (const auto& [id, node] : reader.named(root["cameras"], "cameras")) read_camera(reader, id, node, site);
    for (const auto& [id, node] : reader.named(root["robots"], "robots")) read_robot(reader, id, node, site);
    read_installed(reader, root, site);
    for (const auto& [id, node] : reader.named(root["zones"], "zones")) site.zones.push_back(read_zone(reader, id, node));
    site.plan = read_plan(reader, root["plan"], site.folder);
    site.outputs = read_outputs(reader, root["outputs"]);
    check_topics(reader, root, site);
    check_ros_topics(reader, root, site);
    if (root["cameras"].IsDefined() && root["cameras"].IsMap()) check_references(reader, root, site);
}

}  // namespace

LoadedSite parse_site(std::string_view text, const std::filesystem::path& folder) {
    LoadedSite loaded;
    loaded.site.folder = folder;
    if (!is_utf8(text, loaded.problems)) return loaded;
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

/// The robots that a CSV file speaks of: its second column.
static std::vector<std::string> robots_in(const std::filesystem::path& file) {
    std::vector<std::string> robots;
    std::ifstream lines(file);
    for (std::string line; std::getline(lines, line);) {
        const std::string robot(csv_field(csv_fields(line), 1));
        if (robot.empty()) continue;
        if (std::find(robots.begin(), robots.end(), robot) == robots.end()) robots.push_back(robot);
    }
    return robots;
}

Result<Site> load_session(const std::filesystem::path& session) {
    auto site = load_site(site_file_of(session));
    std::error_code failure;
    if (!site || !std::filesystem::is_directory(session, failure)) return site;
    const auto speaks_of = [](const std::vector<std::string>& robots, const SiteRobot& robot) {
        return std::find(robots.begin(), robots.end(), robot.id) != robots.end();
    };
    const auto driven = robots_in(session / "odometry.csv");
    const auto ranged = robots_in(session / "ranges.csv");
    const auto detecting = robots_in(session / "sightings.csv");
    for (SiteRobot& robot : site->robots) {
        if (!robot.many && speaks_of(driven, robot) && (!robot.odometry || robot.odometry->source.empty())) {
            if (!robot.odometry) robot.odometry.emplace();
            robot.odometry->source = "odometry.csv";
        }
        if (!robot.many && speaks_of(ranged, robot)) {
            if (robot.receivers.empty()) robot.receivers.push_back(somewhere_on(robot));
            if (robot.receivers.front().source.empty()) robot.receivers.front().source = "ranges.csv";
        }
        if (!robot.many && speaks_of(detecting, robot)) {
            if (!robot.detector) robot.detector.emplace();
            if (robot.detector->source.empty()) robot.detector->source = "sightings.csv";
        }
    }
    return site;
}

}  // namespace roomfix
