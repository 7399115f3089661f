#include "roomfix/pipeline/mqtt_sink.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "roomfix/connect/mqtt_payload.hpp"
#include "roomfix/connect/secret.hpp"

namespace roomfix {

MqttSink::MqttSink(const Site& site, const MqttOutput& output)
    : output_(output), topics_(output.prefix + "/" + topic_word(site.name)), node_(topic_word(output.prefix + "_" + site.name)) {}

Result<MqttConnection> mqtt_connection(const Site& site, const MqttOutput& output) {
    MqttConnection connection{output.host, output.port, "", output.user, "", output.tls, ""};
    if (output.password) {
        auto password = secret_text(*output.password, site, "the password of outputs.mqtt");
        if (!password) return password.error();
        connection.password = *password;
    }
    if (connection.tls) {
        for (std::string* file : {&connection.tls->ca, &connection.tls->certificate, &connection.tls->key}) {
            if (!file->empty()) *file = resolved_path(site, *file);
        }
    }
    return connection;
}

Result<std::unique_ptr<MqttSink>> MqttSink::open(const Site& site, const MqttOutput& output) {
    std::unique_ptr<MqttSink> sink(new MqttSink(site, output));
    auto connection = mqtt_connection(site, output);
    if (!connection) return connection.error();
    connection->status_topic = sink->topics_ + "/status";
    auto client = MqttClient::start(*connection);
    if (!client) return client.error();
    sink->client_ = std::move(*client);
    constexpr double patience = 2;  // s: the first fixes of a recording should not be lost
    (void)sink->client_->wait_until_connected(patience);
    for (const SiteRobot& robot : site.robots) {
        if (robot.many) continue;
        sink->lasting_.insert(robot.id);
        sink->introduce(robot.id);
    }
    return sink;
}

std::string MqttSink::name() const { return fmt::format("MQTT at {}:{}", output_.host, output_.port); }

/// A robot of which nothing was said yet.
void MqttSink::introduce(const std::string& robot) {
    last_.emplace(robot, 0);
    client_->retain(topics_ + "/" + topic_word(robot) + "/status", "offline");
    if (!output_.home_assistant || !lasting_.contains(robot)) return;
    for (const auto& [topic, configuration] : home_assistant_discovery(topics_, node_, robot)) client_->retain(topic, configuration);
}

/// Does the rate allow another pose?
bool MqttSink::is_due(Nanoseconds time, Nanoseconds& last) const {
    if (output_.rate > 0 && last > 0 && time - last < from_seconds(0.999 / output_.rate)) return false;
    last = time;
    return true;
}

void MqttSink::publish(const Fix& fix, const FixBatch& batch) {
    const std::string base = topics_ + "/" + topic_word(fix.robot);
    if (!last_.contains(fix.robot)) introduce(fix.robot);
    client_->retain(base + "/status", fix.status == FixStatus::none ? "offline" : "online");
    if (fix.status == FixStatus::none) return;
    const std::vector<std::string> within = batch.zones_of(fix.robot);
    client_->retain(base + "/zone", within.empty() ? "None" : within.front());
    if (is_due(fix.time, last_[fix.robot])) client_->publish(base + "/pose", pose_payload(fix));
}

/// Unknown things, and robots of which there are many, get ever new names: those that are gone are forgotten.
void MqttSink::forget_gone(const FixBatch& batch) {
    constexpr Nanoseconds long_ago = from_seconds(10);
    std::erase_if(last_unknown_, [&](const auto& seen) { return batch.time - seen.second > long_ago; });
    std::erase_if(last_, [&](const auto& robot) {
        const auto is_it = [&](const Fix& fix) { return fix.robot == robot.first; };
        if (lasting_.contains(robot.first) || std::any_of(batch.all.begin(), batch.all.end(), is_it)) return false;
        for (const char* topic : {"/status", "/zone"}) client_->retain(topics_ + "/" + topic_word(robot.first) + topic, "");
        return true;
    });
}

Result<void> MqttSink::give(const FixBatch& batch) {
    for (const ZoneEvent& event : batch.zone_events) client_->publish(topics_ + "/zones/" + event.zone, zone_payload(event.time, event.robot, event.entered));
    for (const Fix& fix : batch.given) {
        if (fix.robot.empty()) continue;
        if (!fix.unknown) {
            publish(fix, batch);
        } else if (fix.status != FixStatus::none && is_due(fix.time, last_unknown_[fix.robot])) {
            client_->publish(topics_ + "/unknown/" + topic_word(fix.robot) + "/pose", pose_payload(fix));
        }
    }
    forget_gone(batch);
    return {};
}

Result<void> MqttSink::finish() {
    const MqttState state = client_->state();
    client_->disconnect();
    if (state.lost == 0) return {};
    if (state.connected) return Error{fmt::format("{}: {} messages were not sent, while there was no connection", name(), state.lost)};
    const std::string problem = state.problem.empty() ? "nobody there has answered yet: is it a broker, and is this its port?" : state.problem;
    return Error{fmt::format("{}: {} messages were not sent: {}", name(), state.lost, problem)};
}

SinkState MqttSink::state() const {
    const MqttState state = client_->state();
    return {name(), state.connected ? "ok" : "failed", state.problem, state.lost};
}

}  // namespace roomfix
