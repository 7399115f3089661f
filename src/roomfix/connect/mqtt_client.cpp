#include "roomfix/connect/mqtt_client.hpp"

#ifdef ROOMFIX_WITH_MQTT

#include <fmt/format.h>
#include <mosquitto.h>
#include <mqtt_protocol.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <cstring>
#include <map>
#include <mutex>
#include <thread>
#include <utility>

#include "roomfix/connect/tls_problem.hpp"

namespace roomfix {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr int keep_alive = 15;                    // s: a broker that says nothing for longer is gone
constexpr milliseconds shortest_pause{250};       // before another try
constexpr milliseconds longest_pause{4000};       // so that a broker that came back is found within 5 s
constexpr milliseconds longest_handshake{10000};  // a broker that takes longer to answer is tried anew
constexpr milliseconds longest_goodbye{1000};
constexpr int loop_wait = 100;  // ms; whatever is to be sent wakes the loop
constexpr int at_most_once = 0;
constexpr int at_least_once = 1;

struct FreeClient {
    void operator()(mosquitto* client) const { mosquitto_destroy(client); }
};

void use_library_once() {
    static const int ready = mosquitto_lib_init();
    (void)ready;
}

}  // namespace

struct MqttClient::Impl {
    MqttConnection connection;
    std::vector<std::string> topics;
    Listener listener;
    std::unique_ptr<mosquitto, FreeClient> client;

    std::mutex sending;        // held while retained states are changed and sent, so that the newest is sent last; taken before `mutex`
    mutable std::mutex mutex;  // guards what follows; never held while the library is called, which calls back
    mutable std::condition_variable changed;
    std::map<std::string, std::string> retained;
    MqttState state;
    std::string detail;    // what the library said last of what went wrong
    bool refused = false;  // the broker answered, but not with yes
    bool stopping = false;
    std::thread thread;

    Result<void> set_up();
    void work();
    void serve();
    void pause(milliseconds time);
    void note_failure(int code, int system_error);
    void note_connected(int reason);
    void say_goodbye();
    void send(const std::string& topic, const std::string& payload, int qos, bool kept) const;
    bool connected() const {
        const std::lock_guard lock(mutex);
        return state.connected;
    }
    bool stops() const {
        const std::lock_guard lock(mutex);
        return stopping;
    }
};

Result<void> MqttClient::Impl::set_up() {
    use_library_once();
    client.reset(mosquitto_new(connection.client_id.empty() ? nullptr : connection.client_id.c_str(), true, this));
    if (!client) return Error{"MQTT: no client can be made: is there memory left?"};
    mosquitto_int_option(client.get(), MOSQ_OPT_PROTOCOL_VERSION, MQTT_PROTOCOL_V5);
    mosquitto_threaded_set(client.get(), true);
    if (!connection.user.empty()) mosquitto_username_pw_set(client.get(), connection.user.c_str(), connection.password.c_str());
    if (!connection.status_topic.empty()) mosquitto_will_set_v5(client.get(), connection.status_topic.c_str(), 7, "offline", at_least_once, true, nullptr);
    if (connection.tls) {
        const TlsFiles& tls = *connection.tls;
        const auto name = [](const std::string& file) { return file.empty() ? nullptr : file.c_str(); };
        int code = MOSQ_ERR_SUCCESS;
        if (tls.ca.empty()) mosquitto_int_option(client.get(), MOSQ_OPT_TLS_USE_OS_CERTS, 1);
        code = mosquitto_tls_set(client.get(), name(tls.ca), tls.ca.empty() ? "/etc/ssl/certs" : nullptr, name(tls.certificate), name(tls.key), nullptr);
        if (code != MOSQ_ERR_SUCCESS) {
            return Error{fmt::format("MQTT: the files of 'tls' cannot be used ({}): check that ca {}, certificate {} and key {} can be read",
                                     mosquitto_strerror(code), tls.ca, tls.certificate, tls.key)};
        }
    }
    mosquitto_connect_v5_callback_set(
        client.get(), [](mosquitto*, void* self, int reason, int, const mosquitto_property*) { static_cast<Impl*>(self)->note_connected(reason); });
    mosquitto_log_callback_set(client.get(), [](mosquitto*, void* self, int level, const char* text) {
        if (level != MOSQ_LOG_ERR) return;
        const std::lock_guard lock(static_cast<Impl*>(self)->mutex);
        static_cast<Impl*>(self)->detail = text;
    });
    if (listener) {
        mosquitto_message_v5_callback_set(client.get(), [](mosquitto*, void* self, const mosquitto_message* message, const mosquitto_property*) {
            const char* bytes = static_cast<const char*>(message->payload);
            static_cast<Impl*>(self)->listener(message->topic, {bytes ? bytes : "", static_cast<std::size_t>(message->payloadlen)});
        });
    }
    return {};
}

void MqttClient::Impl::send(const std::string& topic, const std::string& payload, int qos, bool kept) const {
    mosquitto_publish_v5(client.get(), nullptr, topic.c_str(), static_cast<int>(payload.size()), payload.data(), qos, kept, nullptr);
}

void MqttClient::Impl::note_connected(int reason) {
    const std::lock_guard ordered(sending);
    std::map<std::string, std::string> states;
    {
        const std::lock_guard lock(mutex);
        state.connected = reason == 0;
        refused = reason != 0;
        if (refused) {
            state.problem = fmt::format("the broker {}:{} refuses the connection: {}; check user and password", connection.host, connection.port,
                                        mosquitto_reason_string(reason));
            return;
        }
        state.problem.clear();
        states = retained;
    }
    changed.notify_all();
    for (const std::string& topic : topics) mosquitto_subscribe(client.get(), nullptr, topic.c_str(), at_most_once);
    if (!connection.status_topic.empty()) send(connection.status_topic, "online", at_least_once, true);
    for (const auto& [topic, payload] : states) send(topic, payload, at_least_once, true);
}

void MqttClient::Impl::note_failure(int code, int system_error) {
    std::string certificate;
    if (code == MOSQ_ERR_TLS) certificate = tls_problem(connection.host, connection.port, connection.tls ? connection.tls->ca : "");
    const std::lock_guard lock(mutex);
    const bool was_connected = std::exchange(state.connected, false);
    if (refused) return;  // what the broker answered says more
    std::string reason = code == MOSQ_ERR_ERRNO ? std::strerror(system_error) : mosquitto_strerror(code);
    if (code == MOSQ_ERR_TLS) reason = fmt::format("no TLS ({}): is this the port at which the broker speaks it?", detail.empty() ? reason : detail);
    if (code == MOSQ_ERR_CONN_LOST && !was_connected)
        reason = "what listens there does not answer as a broker: is it one, and is this its port, with or without TLS?";
    if (!certificate.empty()) reason = "its certificate is not believed: " + certificate;
    state.problem = fmt::format("the broker {}:{} cannot be reached: {}", connection.host, connection.port, reason);
}

void MqttClient::Impl::pause(milliseconds time) {
    std::unique_lock lock(mutex);
    changed.wait_for(lock, time, [this] { return stopping; });
}

/// From a connection's beginning to its end.
void MqttClient::Impl::serve() {
    {
        const std::lock_guard lock(mutex);
        detail.clear();
        refused = false;
    }
    errno = 0;
    int code = mosquitto_connect_async(client.get(), connection.host.c_str(), connection.port, keep_alive);
    const auto begin = steady_clock::now();
    while (code == MOSQ_ERR_SUCCESS && !stops()) {
        errno = 0;
        code = mosquitto_loop(client.get(), loop_wait, 1);
        if (code == MOSQ_ERR_SUCCESS && !connected() && steady_clock::now() - begin > longest_handshake) code = MOSQ_ERR_CONN_LOST;
    }
    if (code != MOSQ_ERR_SUCCESS) note_failure(code, errno);
}

void MqttClient::Impl::work() {
    milliseconds next = shortest_pause;
    while (!stops()) {
        const auto begin = steady_clock::now();
        serve();
        if (steady_clock::now() - begin > longest_pause) next = shortest_pause;  // it had worked for a while
        if (!stops()) pause(next);
        next = std::min(2 * next, longest_pause);
    }
    say_goodbye();
}

void MqttClient::Impl::say_goodbye() {
    if (!connected()) return;
    if (!connection.status_topic.empty()) send(connection.status_topic, "offline", at_least_once, true);
    mosquitto_disconnect_v5(client.get(), 0, nullptr);
    const auto begin = steady_clock::now();
    while (mosquitto_want_write(client.get()) && steady_clock::now() - begin < longest_goodbye) {
        if (mosquitto_loop(client.get(), loop_wait, 1) != MOSQ_ERR_SUCCESS) return;
    }
}

MqttClient::MqttClient(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {
    impl_->thread = std::thread([this] { impl_->work(); });
}

MqttClient::~MqttClient() { disconnect(); }

void MqttClient::disconnect() {
    {
        const std::lock_guard lock(impl_->mutex);
        impl_->stopping = true;
    }
    impl_->changed.notify_all();
    if (impl_->thread.joinable()) impl_->thread.join();
}

bool MqttClient::wait_until_connected(double longest) const {
    std::unique_lock lock(impl_->mutex);
    return impl_->changed.wait_for(lock, std::chrono::duration<double>(longest), [this] { return impl_->state.connected; });
}

Result<std::unique_ptr<MqttClient>> MqttClient::start(const MqttConnection& connection, std::vector<std::string> topics, Listener listener) {
    auto impl = std::make_unique<Impl>();
    impl->connection = connection;
    impl->topics = std::move(topics);
    impl->listener = std::move(listener);
    if (auto ready = impl->set_up(); !ready) return ready.error();
    return std::unique_ptr<MqttClient>(new MqttClient(std::move(impl)));
}

void MqttClient::publish(const std::string& topic, const std::string& payload) {
    {
        const std::lock_guard lock(impl_->mutex);
        if (!impl_->state.connected) {
            ++impl_->state.lost;
            return;
        }
    }
    impl_->send(topic, payload, at_most_once, false);
}

void MqttClient::retain(const std::string& topic, const std::string& payload) {
    const std::lock_guard ordered(impl_->sending);
    {
        const std::lock_guard lock(impl_->mutex);
        std::string& kept = impl_->retained[topic];
        if (kept == payload) return;
        kept = payload;
        if (payload.empty()) impl_->retained.erase(topic);
        if (!impl_->state.connected) return;
    }
    impl_->send(topic, payload, at_least_once, true);
}

MqttState MqttClient::state() const {
    const std::lock_guard lock(impl_->mutex);
    return impl_->state;
}

}  // namespace roomfix

#else

namespace roomfix {

struct MqttClient::Impl {};

MqttClient::MqttClient(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
MqttClient::~MqttClient() = default;
void MqttClient::disconnect() {}
bool MqttClient::wait_until_connected(double) const { return false; }
Result<std::unique_ptr<MqttClient>> MqttClient::start(const MqttConnection&, std::vector<std::string>, Listener) {
    return Error{"this roomfix was built without MQTT: install libmosquitto-dev and build it again, or take 'mqtt' out of the site file"};
}
void MqttClient::publish(const std::string&, const std::string&) {}
void MqttClient::retain(const std::string&, const std::string&) {}
MqttState MqttClient::state() const { return {}; }

}  // namespace roomfix

#endif
