#include "roomfix/site/outputs_text.hpp"

#include <fmt/format.h>

#include "roomfix/base/number.hpp"
#include "roomfix/site/quoted_text.hpp"

namespace roomfix {
namespace {

std::string secret_text(const Secret& secret) {
    return secret.file.empty() ? "{env: " + quoted_text(secret.variable) + "}" : "{file: " + quoted_text(secret.file) + "}";
}

std::string tls_text(const TlsFiles& tls) {
    std::string text;
    const auto add = [&](const char* key, const std::string& file) {
        if (!file.empty()) text += fmt::format("{}{}: {}", text.empty() ? "" : ", ", key, quoted_text(file));
    };
    add("ca", tls.ca);
    add("certificate", tls.certificate);
    add("key", tls.key);
    return "{" + text + "}";
}

std::string web_text(const WebOutput& web) {
    std::string text = fmt::format("{{host: {}, port: {}", quoted_text(web.host), web.port);
    if (web.tls) text += ", tls: " + tls_text(*web.tls);
    if (web.token) text += ", token: " + secret_text(*web.token);
    if (web.operator_token) text += ", operator: " + secret_text(*web.operator_token);
    if (web.insecure) text += ", insecure: true";
    return text + "}";
}

std::string mqtt_text(const MqttOutput& mqtt) {
    std::string text = fmt::format("{{host: {}, port: {}, prefix: {}", quoted_text(mqtt.host), mqtt.port, quoted_text(mqtt.prefix));
    if (!mqtt.user.empty()) text += ", user: " + quoted_text(mqtt.user);
    if (mqtt.password) text += ", password: " + secret_text(*mqtt.password);
    if (mqtt.tls) text += ", tls: " + tls_text(*mqtt.tls);
    return text + fmt::format(", rate: {}, home_assistant: {}}}", number_text(mqtt.rate), mqtt.home_assistant);
}

}  // namespace

std::string outputs_text(const Outputs& outputs) {
    std::string text;
    if (outputs.web) text += "  web: " + web_text(*outputs.web) + "\n";
    if (!outputs.jsonl.empty()) text += "  jsonl: " + quoted_text(outputs.jsonl) + "\n";
    if (!outputs.tum.empty()) text += "  tum: " + quoted_text(outputs.tum) + "\n";
    if (outputs.foxglove) text += "  foxglove: " + web_text(*outputs.foxglove) + "\n";
    if (outputs.mqtt) text += "  mqtt: " + mqtt_text(*outputs.mqtt) + "\n";
    if (outputs.ros2) text += fmt::format("  ros2: {{domain: {}, robot_transform: {}}}\n", outputs.ros2->domain, outputs.ros2->robot_transform);
    if (outputs.history) {
        text += fmt::format("  history: {{database: {}, days: {}}}\n", quoted_text(outputs.history->database), number_text(outputs.history->days));
    }
    return text.empty() ? "" : "outputs:\n" + text;
}

}  // namespace roomfix
