#include "roomfix/site/read_outputs.hpp"

#include <fmt/format.h>

namespace roomfix {
namespace {

bool read_flag(YamlReader& reader, const YAML::Node& node, const std::string& what, bool otherwise) {
    if (!node.IsDefined()) return otherwise;
    bool flag = otherwise;
    if (!node.IsScalar() || !YAML::convert<bool>::decode(node, flag)) reader.error(node, what + " is true or false");
    return flag;
}

std::optional<Secret> read_secret(YamlReader& reader, const YAML::Node& node, const std::string& what) {
    if (!node.IsDefined()) return std::nullopt;
    if (node.IsScalar()) {
        reader.error(node, fmt::format("{} does not stand in the site file: write {{file: NAME}} or {{env: VARIABLE}}", what));
        return std::nullopt;
    }
    if (!reader.map(node, what, {"file", "env"})) return std::nullopt;
    const Secret secret{reader.text(node["file"], what + ".file").value_or(""), reader.text(node["env"], what + ".env").value_or("")};
    if (secret.file.empty() == secret.variable.empty()) reader.error(node, what + " needs one of file and env");
    return secret;
}

std::optional<TlsFiles> read_tls(YamlReader& reader, const YAML::Node& node, const std::string& what) {
    if (!node.IsDefined() || !reader.map(node, what, {"ca", "certificate", "key"})) return std::nullopt;
    TlsFiles tls;
    tls.ca = reader.text(node["ca"], what + ".ca").value_or("");
    tls.certificate = reader.text(node["certificate"], what + ".certificate").value_or("");
    tls.key = reader.text(node["key"], what + ".key").value_or("");
    if (tls.certificate.empty() != tls.key.empty()) reader.error(node, what + ": certificate and key come together");
    return tls;
}

/// What every server has; `web` brings its own port.
void read_listening(YamlReader& reader, const YAML::Node& node, const std::string& what, WebOutput& web) {
    web.host = reader.text(node["host"], what + ".host").value_or(web.host);
    web.port = reader.integer(node["port"], what + ".port", 0, 65535).value_or(web.port);
    web.tls = read_tls(reader, node["tls"], what + ".tls");
    if (web.tls && web.tls->certificate.empty()) reader.error(node["tls"], what + ".tls needs a certificate and its key");
    if (web.tls && !web.tls->ca.empty()) reader.error(node["tls"], what + ".tls: a 'ca' is of no use here: who looks shows a token, no certificate");
    web.token = read_secret(reader, node["token"], what + ".token");
    web.insecure = read_flag(reader, node["insecure"], what + ".insecure", false);
    if (const std::string reason = refusal(web, what); !reason.empty()) reader.error(node, reason);
}

WebOutput read_web(YamlReader& reader, const YAML::Node& node) {
    WebOutput web;
    if (!reader.map(node, "outputs.web", {"host", "port", "tls", "token", "operator", "insecure"})) return web;
    web.operator_token = read_secret(reader, node["operator"], "outputs.web.operator");
    read_listening(reader, node, "outputs.web", web);
    return web;
}

/// Nothing can be changed through it: it has no operator.
WebOutput read_foxglove(YamlReader& reader, const YAML::Node& node) {
    WebOutput web;
    web.port = 8765;
    if (reader.map(node, "outputs.foxglove", {"host", "port", "tls", "token", "insecure"})) read_listening(reader, node, "outputs.foxglove", web);
    return web;
}

/// A part of a topic's name: MQTT's wildcards and separators would make it another topic.
void check_topic(YamlReader& reader, const YAML::Node& node, const std::string& prefix) {
    const bool ends_well = !prefix.empty() && prefix.front() != '/' && prefix.back() != '/' && prefix.front() != '$';
    if (!ends_well || prefix.find_first_of("+#") != std::string::npos || prefix.find("//") != std::string::npos) {
        reader.error(node, fmt::format("outputs.mqtt.prefix '{}' is no beginning of a topic: words with single slashes between them, without + # $", prefix));
    }
}

MqttOutput read_mqtt(YamlReader& reader, const YAML::Node& node) {
    MqttOutput mqtt;
    if (!reader.map(node, "outputs.mqtt", {"host", "port", "prefix", "user", "password", "tls", "rate", "home_assistant"})) return mqtt;
    mqtt.tls = read_tls(reader, node["tls"], "outputs.mqtt.tls");
    if (mqtt.tls) mqtt.port = 8883;
    mqtt.host = reader.text(node["host"], "outputs.mqtt.host").value_or(mqtt.host);
    mqtt.port = reader.integer(node["port"], "outputs.mqtt.port", 1, 65535).value_or(mqtt.port);
    if (node["prefix"].IsDefined()) {
        mqtt.prefix = reader.text(node["prefix"], "outputs.mqtt.prefix").value_or(mqtt.prefix);
        check_topic(reader, node["prefix"], mqtt.prefix);
    }
    mqtt.user = reader.text(node["user"], "outputs.mqtt.user").value_or("");
    mqtt.password = read_secret(reader, node["password"], "outputs.mqtt.password");
    if (mqtt.password && mqtt.user.empty()) reader.error(node["password"], "outputs.mqtt has a password, but no user");
    mqtt.rate = reader.number(node["rate"], "outputs.mqtt.rate", 0, 1000).value_or(mqtt.rate);
    mqtt.home_assistant = read_flag(reader, node["home_assistant"], "outputs.mqtt.home_assistant", false);
    return mqtt;
}

Ros2Output read_ros2(YamlReader& reader, const YAML::Node& node) {
    Ros2Output ros2;
    if (!reader.map(node, "outputs.ros2", {"domain", "robot_transform"})) return ros2;
    ros2.domain = reader.integer(node["domain"], "outputs.ros2.domain", 0, 232).value_or(ros2.domain);
    ros2.robot_transform = read_flag(reader, node["robot_transform"], "outputs.ros2.robot_transform", false);
    return ros2;
}

HistoryOutput read_history(YamlReader& reader, const YAML::Node& node) {
    HistoryOutput history;
    if (!reader.map(node, "outputs.history", {"database", "days"})) return history;
    history.database = reader.text(node["database"], "outputs.history.database").value_or(history.database);
    history.days = reader.number(node["days"], "outputs.history.days", 1e-4, 36500).value_or(history.days);
    return history;
}

}  // namespace

Outputs read_outputs(YamlReader& reader, const YAML::Node& node) {
    Outputs outputs;
    if (!node.IsDefined() || !reader.map(node, "outputs", {"jsonl", "tum", "web", "mqtt", "ros2", "history", "foxglove"})) return outputs;
    outputs.jsonl = reader.text(node["jsonl"], "outputs.jsonl").value_or("");
    if (node["web"].IsDefined()) outputs.web = read_web(reader, node["web"]);
    if (node["foxglove"].IsDefined()) outputs.foxglove = read_foxglove(reader, node["foxglove"]);
    outputs.tum = reader.text(node["tum"], "outputs.tum").value_or("");
    if (node["mqtt"].IsDefined()) outputs.mqtt = read_mqtt(reader, node["mqtt"]);
    if (node["ros2"].IsDefined()) outputs.ros2 = read_ros2(reader, node["ros2"]);
    if (node["history"].IsDefined()) outputs.history = read_history(reader, node["history"]);
    return outputs;
}

}  // namespace roomfix
