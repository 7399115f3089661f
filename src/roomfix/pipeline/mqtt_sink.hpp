// Fixes, states of robots and zones to an MQTT broker.
#pragma once

#include <map>
#include <memory>
#include <set>
#include <string>

#include "roomfix/connect/mqtt_client.hpp"
#include "roomfix/pipeline/fix_sink.hpp"
#include "roomfix/site/site.hpp"

namespace roomfix {

/// How to reach the broker, with the password. An error where that is not there.
Result<MqttConnection> mqtt_connection(const Site& site, const MqttOutput& output);

class MqttSink final : public FixSink {
public:
    /// An error where the settings cannot work. A broker that cannot be reached is none: it is tried again and again.
    static Result<std::unique_ptr<MqttSink>> open(const Site& site, const MqttOutput& output);

    std::string name() const override;
    Result<void> give(const FixBatch& batch) override;
    Result<void> finish() override;
    SinkState state() const override;

private:
    MqttSink(const Site& site, const MqttOutput& output);
    void introduce(const std::string& robot);
    void publish(const Fix& fix, const FixBatch& batch);
    bool is_due(Nanoseconds time, Nanoseconds& last) const;
    void forget_gone(const FixBatch& batch);

    MqttOutput output_;
    std::string topics_;  // PREFIX/SITE
    std::string node_;
    std::set<std::string> lasting_;                    // robots that the site file names
    std::map<std::string, Nanoseconds> last_;          // pose of each robot
    std::map<std::string, Nanoseconds> last_unknown_;  // of what is no robot
    std::unique_ptr<MqttClient> client_;
};

}  // namespace roomfix
