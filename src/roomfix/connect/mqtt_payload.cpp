#include "roomfix/connect/mqtt_payload.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

#include "roomfix/connect/fix_json.hpp"
#include "roomfix/connect/iso_time.hpp"
#include "roomfix/connect/json_text.hpp"
#include "roomfix/version.hpp"

namespace roomfix {
namespace {

using Json = nlohmann::ordered_json;

double rounded(double value) { return std::round(value * 1e6) / 1e6; }

/// m, 1 sigma along the worst direction on the floor.
double worst_sigma(const Eigen::Matrix3d& p) {
    const double mean = 0.5 * (p(0, 0) + p(1, 1));
    return std::sqrt(mean + std::hypot(0.5 * (p(0, 0) - p(1, 1)), p(0, 1)));
}

}  // namespace

std::string topic_word(const std::string& name) {
    std::string word = name;
    for (char& c : word) {
        const bool fits = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '_';
        if (!fits) c = '_';
    }
    return word.empty() ? "_" : word;
}

std::string pose_payload(const Fix& fix) {
    const Eigen::Matrix3d& p = fix.covariance;
    Json json = {{"t", iso_time(fix.time)}, {"frame", "map"}, {"x", rounded(fix.pose.x)}, {"y", rounded(fix.pose.y)}, {"z", 0.0}};
    json["yaw"] = fix.yaw_known ? Json(rounded(fix.pose.yaw)) : Json();
    json["cov"] = {p(0, 0), p(0, 1), p(0, 2), p(1, 1), p(1, 2), p(2, 2)};
    json["sigma"] = rounded(worst_sigma(p));
    json["ok"] = fix.status == FixStatus::ok;
    json["status"] = name_of(fix.status);
    json["src"] = fix.sources;
    if (fix.identity < 0.9995) json["identity"] = std::round(fix.identity * 1e3) / 1e3;
    return json_line<Json>(json);
}

std::string zone_payload(Nanoseconds time, const std::string& robot, bool entered) {
    return json_line<Json>({{"t", iso_time(time)}, {"robot", robot}, {"event", entered ? "enter" : "leave"}});
}

std::vector<std::pair<std::string, std::string>> home_assistant_discovery(const std::string& topics, const std::string& node, const std::string& robot) {
    const std::string word = topic_word(robot);
    const std::string base = topics + "/" + word;
    const Json device = {{"identifiers", {node + "_" + word}}, {"name", robot}, {"manufacturer", "roomfix"}, {"model", "robot"}, {"sw_version", version}};
    const Json common = {{"availability", {{{"topic", topics + "/status"}}, {{"topic", base + "/status"}}}}, {"availability_mode", "all"}, {"device", device}};
    std::vector<std::pair<std::string, std::string>> told;

    Json tracker = {{"name", robot},
                    {"unique_id", node + "_" + word},
                    {"state_topic", base + "/zone"},
                    {"json_attributes_topic", base + "/pose"},
                    {"payload_reset", "None"},
                    {"source_type", "gps"}};
    tracker.update(common);
    told.emplace_back("homeassistant/device_tracker/" + node + "/" + word + "/config", json_line(tracker));

    struct Sensor {
        const char* name;
        const char* value;
        const char* unit;
    };
    constexpr Sensor sensors[] = {{"x", "{{ value_json.x }}", "m"},
                                  {"y", "{{ value_json.y }}", "m"},
                                  {"heading", "{{ (value_json.yaw * 57.29578) | round(1) if value_json.yaw is not none else none }}", "°"},
                                  {"sigma", "{{ value_json.sigma }}", "m"}};
    for (const Sensor& sensor : sensors) {
        Json json = {{"name", sensor.name},
                     {"unique_id", node + "_" + word + "_" + sensor.name},
                     {"state_topic", base + "/pose"},
                     {"value_template", sensor.value},
                     {"unit_of_measurement", sensor.unit},
                     {"state_class", "measurement"}};
        json.update(common);
        told.emplace_back("homeassistant/sensor/" + node + "/" + word + "_" + sensor.name + "/config", json_line(json));
    }
    return told;
}

}  // namespace roomfix
