// One connection to an MQTT 5 broker, which may vanish and come back.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "roomfix/base/result.hpp"
#include "roomfix/site/outputs.hpp"

namespace roomfix {

struct MqttConnection {
    std::string host;
    int port = 1883;
    std::string client_id;  // empty: the broker chooses one
    std::string user;
    std::string password;
    std::optional<TlsFiles> tls;  // absolute paths; none: not encrypted
    std::string status_topic;     // says "online" while there is a connection, else "offline", also if this program dies; empty: none
};

struct MqttState {
    bool connected = false;
    std::string problem;  // why not, in words
    long lost = 0;        // messages that were not sent since there was no connection
};

/// Works in a thread of its own and tries again, each time later up to some seconds, whenever the broker cannot be reached. All functions may be called
/// from any thread.
class MqttClient {
public:
    using Listener = std::function<void(const std::string& topic, std::string_view payload)>;

    /// An error where roomfix was built without MQTT, or a certificate cannot be read. That a broker cannot be reached is a state, no error.
    /// `listener` gets what comes on `topics`, from the client's thread.
    static Result<std::unique_ptr<MqttClient>> start(const MqttConnection& connection, std::vector<std::string> topics = {}, Listener listener = {});
    ~MqttClient();
    MqttClient(const MqttClient&) = delete;
    MqttClient& operator=(const MqttClient&) = delete;

    /// Sent at most once; lost while there is no connection.
    void publish(const std::string& topic, const std::string& payload);
    /// A state that subscribers get whenever they come: kept here, too, and sent again with each new connection. Not sent if it is as before; an empty one
    /// takes it back.
    void retain(const std::string& topic, const std::string& payload);
    MqttState state() const;
    /// Waits until there is a connection, at most so long (s); false if there is none.
    bool wait_until_connected(double longest) const;
    /// Says "offline" and ends the connection, after what is under way was sent or a second. The last call, but for `state`.
    void disconnect();

private:
    struct Impl;
    explicit MqttClient(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

}  // namespace roomfix
