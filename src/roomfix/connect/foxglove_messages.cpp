#include "roomfix/connect/foxglove_messages.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "roomfix/connect/json_text.hpp"

namespace roomfix {
namespace {

using nlohmann::json;

constexpr double ellipse_95 = 5.991;  // chi squared of two dimensions
constexpr int ellipse_corners = 32;

json number_schema() { return {{"type", "number"}}; }
json text_schema() { return {{"type", "string"}}; }

json object_schema(const json& properties) { return {{"type", "object"}, {"properties", properties}}; }
json numbers_schema(std::initializer_list<const char*> names) {
    json properties = json::object();
    for (const char* name : names) properties[name] = number_schema();
    return object_schema(properties);
}
json list_schema(const json& items) { return {{"type", "array"}, {"items", items}}; }

json time_schema() { return object_schema({{"sec", {{"type", "integer"}}}, {"nsec", {{"type", "integer"}}}}); }
json vector_schema() { return numbers_schema({"x", "y", "z"}); }
json quaternion_schema() { return numbers_schema({"x", "y", "z", "w"}); }
json colour_schema() { return numbers_schema({"r", "g", "b", "a"}); }
json pose_schema() { return object_schema({{"position", vector_schema()}, {"orientation", quaternion_schema()}}); }

json entity_schema() {
    const json solid = object_schema({{"pose", pose_schema()}, {"size", vector_schema()}, {"color", colour_schema()}});
    json cylinder = solid;
    cylinder["properties"]["bottom_scale"] = number_schema();
    cylinder["properties"]["top_scale"] = number_schema();
    const json line = object_schema({{"type", {{"type", "integer"}}},
                                     {"pose", pose_schema()},
                                     {"thickness", number_schema()},
                                     {"scale_invariant", {{"type", "boolean"}}},
                                     {"points", list_schema(vector_schema())},
                                     {"color", colour_schema()},
                                     {"colors", list_schema(colour_schema())},
                                     {"indices", list_schema({{"type", "integer"}})}});
    const json text = object_schema({{"pose", pose_schema()},
                                     {"billboard", {{"type", "boolean"}}},
                                     {"font_size", number_schema()},
                                     {"scale_invariant", {{"type", "boolean"}}},
                                     {"color", colour_schema()},
                                     {"text", text_schema()}});
    return object_schema({{"timestamp", time_schema()},
                          {"frame_id", text_schema()},
                          {"id", text_schema()},
                          {"lifetime", time_schema()},
                          {"frame_locked", {{"type", "boolean"}}},
                          {"cubes", list_schema(solid)},
                          {"cylinders", list_schema(cylinder)},
                          {"lines", list_schema(line)},
                          {"texts", list_schema(text)}});
}

json time_json(Nanoseconds time) {
    constexpr Nanoseconds second = 1'000'000'000;
    const Nanoseconds whole = time / second - (time % second < 0);
    return {{"sec", whole}, {"nsec", time - whole * second}};
}

json vector_json(double x, double y, double z) { return {{"x", x}, {"y", y}, {"z", z}}; }
json pose_json(double x, double y, double z, double yaw) {
    return {{"position", vector_json(x, y, z)}, {"orientation", {{"x", 0.0}, {"y", 0.0}, {"z", std::sin(yaw / 2)}, {"w", std::cos(yaw / 2)}}}};
}
double direction(const Fix& fix) { return fix.yaw_known ? fix.pose.yaw : 0; }

json colour(double red, double green, double blue, double alpha) { return {{"r", red}, {"g", green}, {"b", blue}, {"a", alpha}}; }

json line_json(const std::vector<Eigen::Vector2d>& points, bool closed, double thickness, const json& colour) {
    json line = {{"type", closed ? 1 : 0}, {"pose", pose_json(0, 0, 0, 0)}, {"thickness", thickness},  {"scale_invariant", false}, {"points", json::array()},
                 {"color", colour},        {"colors", json::array()},       {"indices", json::array()}};
    for (const auto& p : points) line["points"].push_back(vector_json(p.x(), p.y(), 0.01));
    return line;
}

json text_json(const std::string& text, double x, double y, double z) {
    return {{"pose", pose_json(x, y, z, 0)},     {"billboard", true}, {"font_size", 14}, {"scale_invariant", true},
            {"color", colour(0.5, 0.5, 0.5, 1)}, {"text", text}};
}

json entity(const std::string& id, Nanoseconds time, Nanoseconds lifetime) {
    return {{"timestamp", time_json(time)},    {"frame_id", "map"},      {"id", id},
            {"lifetime", time_json(lifetime)}, {"frame_locked", false},  {"metadata", json::array()},
            {"arrows", json::array()},         {"cubes", json::array()}, {"spheres", json::array()},
            {"cylinders", json::array()},      {"lines", json::array()}, {"triangles", json::array()},
            {"texts", json::array()},          {"models", json::array()}};
}

std::string scene(json entities) { return json_line(json{{"deletions", json::array()}, {"entities", std::move(entities)}}); }

/// Where the robot is with 95 % probability.
std::vector<Eigen::Vector2d> ellipse(const Fix& fix) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(fix.covariance.topLeftCorner<2, 2>());
    const Eigen::Matrix2d root = axes.eigenvectors() * (ellipse_95 * axes.eigenvalues().cwiseMax(0)).cwiseSqrt().asDiagonal();
    std::vector<Eigen::Vector2d> points;
    for (int i = 0; i < ellipse_corners; ++i) {
        const double angle = 2 * std::numbers::pi * i / ellipse_corners;
        points.emplace_back(Eigen::Vector2d(fix.pose.x, fix.pose.y) + root * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
    }
    return points;
}

/// The site's robot that a name belongs to: ID, or ID-3 of many.
const SiteRobot* described(const Site& site, const std::string& name) {
    for (const SiteRobot& robot : site.robots) {
        if (robot.many ? name.starts_with(robot.id + "-") : name == robot.id) return &robot;
    }
    return nullptr;
}

json robot_entity(const Site& site, const Fix& fix, Nanoseconds time) {
    constexpr Nanoseconds lifetime = 1'000'000'000;
    json told = entity(fix.robot, time, lifetime);
    const json paint = fix.unknown ? colour(0.8, 0.3, 0.2, 0.7) : colour(0.04, 0.48, 0.46, fix.status == FixStatus::ok ? 0.9 : 0.4);
    double top = 1;
    if (const SiteRobot* robot = fix.unknown ? nullptr : described(site, fix.robot)) {
        top = 2 * half_size(robot->shape).z();
        const Eigen::Vector3d size = 2 * half_size(robot->shape);
        json solid = {
            {"pose", pose_json(fix.pose.x, fix.pose.y, size.z() / 2, direction(fix))}, {"size", vector_json(size.x(), size.y(), size.z())}, {"color", paint}};
        const bool round = std::holds_alternative<Cylinder>(robot->shape);
        if (round) solid["bottom_scale"] = solid["top_scale"] = 1.0;
        told[round ? "cylinders" : "cubes"].push_back(solid);
    }
    told["lines"].push_back(line_json(ellipse(fix), true, 0.02, paint));
    told["texts"].push_back(text_json(fix.robot, fix.pose.x, fix.pose.y, top + 0.2));
    return told;
}

/// Bytes as JSON carries them.
std::string base64(const std::vector<std::uint8_t>& bytes) {
    static constexpr char letters[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    text.reserve((bytes.size() + 2) / 3 * 4);
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        std::uint32_t three = 0;
        for (std::size_t k = 0; k < 3; ++k) three = three << 8 | (i + k < bytes.size() ? bytes[i + k] : 0U);
        for (std::size_t k = 0; k < 4; ++k) text += i + k <= bytes.size() ? letters[three >> (18 - 6 * k) & 63] : '=';
    }
    return text;
}

FoxgloveChannel channel(const std::string& topic, const char* schema, const json& properties) {
    return {topic, std::string("foxglove.") + schema, object_schema(properties).dump()};
}

}  // namespace

FoxgloveChannel pose_channel(const std::string& topic) {
    return channel(topic, "PoseInFrame", {{"timestamp", time_schema()}, {"frame_id", text_schema()}, {"pose", pose_schema()}});
}

FoxgloveChannel scene_channel(const std::string& topic) {
    const json deletion = object_schema({{"timestamp", time_schema()}, {"type", {{"type", "integer"}}}, {"id", text_schema()}});
    return channel(topic, "SceneUpdate", {{"deletions", list_schema(deletion)}, {"entities", list_schema(entity_schema())}});
}

FoxgloveChannel transform_channel(const std::string& topic) {
    return channel(topic, "FrameTransform",
                   {{"timestamp", time_schema()},
                    {"parent_frame_id", text_schema()},
                    {"child_frame_id", text_schema()},
                    {"translation", vector_schema()},
                    {"rotation", quaternion_schema()}});
}

FoxgloveChannel picture_channel(const std::string& topic) {
    const json data = {{"type", "string"}, {"contentEncoding", "base64"}};
    return channel(topic, "CompressedImage", {{"timestamp", time_schema()}, {"frame_id", text_schema()}, {"data", data}, {"format", text_schema()}});
}

std::string pose_message(const Fix& fix) {
    return json_line(json{{"timestamp", time_json(fix.time)}, {"frame_id", "map"}, {"pose", pose_json(fix.pose.x, fix.pose.y, 0, direction(fix))}});
}

std::string transform_message(const Fix& fix) {
    const json pose = pose_json(fix.pose.x, fix.pose.y, 0, direction(fix));
    return json_line(json{{"timestamp", time_json(fix.time)},
                          {"parent_frame_id", "map"},
                          {"child_frame_id", fix.robot},
                          {"translation", pose["position"]},
                          {"rotation", pose["orientation"]}});
}

std::string map_scene(const Site& site) {
    json map = entity("map", 0, 0);
    for (const Polyline& wall : site.walls) map["lines"].push_back(line_json(wall, false, 0.05, colour(0.4, 0.4, 0.4, 1)));
    for (const SiteZone& zone : site.zones) {
        map["lines"].push_back(line_json(zone.border, true, 0.03, colour(0.6, 0.6, 0.2, 1)));
        map["texts"].push_back(text_json(zone.id, zone.border.front().x(), zone.border.front().y(), 0.1));
    }
    for (const SiteBeacon& beacon : site.beacons) map["texts"].push_back(text_json(beacon.id, beacon.position.x(), beacon.position.y(), beacon.position.z()));
    return scene(json::array({map}));
}

std::string robots_scene(const Site& site, const std::vector<Fix>& fixes, Nanoseconds time) {
    json entities = json::array();
    for (const Fix& fix : fixes) {
        if (fix.status != FixStatus::none) entities.push_back(robot_entity(site, fix, time));
    }
    return scene(std::move(entities));
}

std::string picture_message(const std::string& camera, Nanoseconds time, const std::vector<std::uint8_t>& jpeg) {
    return json_line(json{{"timestamp", time_json(time)}, {"frame_id", camera}, {"data", base64(jpeg)}, {"format", "jpeg"}});
}

}  // namespace roomfix
