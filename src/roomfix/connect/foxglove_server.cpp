#include "roomfix/connect/foxglove_server.hpp"

#include <fmt/format.h>

#ifdef ROOMFIX_WITH_FOXGLOVE

#include <libwebsockets.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <deque>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>
#include <vector>

#include "roomfix/connect/foxglove_request.hpp"
#include "roomfix/connect/json_text.hpp"
#include "roomfix/connect/little_endian.hpp"

namespace roomfix {
namespace {

using nlohmann::json;

constexpr const char* subprotocol = "foxglove.websocket.v1";
constexpr std::size_t most_waiting = 8 * 1024 * 1024;  // bytes for one client; what is older is thrown away
constexpr std::size_t longest_request = 64 * 1024;     // bytes
constexpr std::size_t most_subscriptions = 1000;       // of one client
constexpr std::size_t most_clients = 200;
constexpr unsigned char message_data = 1;  // opcode of a binary frame

/// A frame with the room in front of it that the library wants.
class Frame {
public:
    Frame(bool text, std::size_t size) : text_(text), bytes_(LWS_PRE + size) {}
    explicit Frame(const std::string& text) : Frame(true, text.size()) { std::memcpy(data(), text.data(), text.size()); }
    unsigned char* data() { return bytes_.data() + LWS_PRE; }
    std::size_t size() const { return bytes_.size() - LWS_PRE; }
    bool is_text() const { return text_; }

private:
    bool text_;
    std::vector<unsigned char> bytes_;
};

Frame data_frame(std::uint32_t subscription, Nanoseconds time, const std::string& payload) {
    Bytes header = {message_data};
    append(header, subscription);
    append(header, static_cast<std::uint64_t>(time));
    Frame frame(false, header.size() + payload.size());
    std::memcpy(frame.data(), header.data(), header.size());
    std::memcpy(frame.data() + header.size(), payload.data(), payload.size());
    return frame;
}

struct Client {
    std::map<std::uint32_t, std::size_t> subscriptions;  // their channels
    std::deque<Frame> waiting;
    std::size_t waiting_bytes = 0;
    std::string request;    // as much as has come of it
    bool hopeless = false;  // it asks and asks and takes nothing
};

struct Message {
    Nanoseconds time = 0;
    std::string json;
};

json advertisement(const std::vector<FoxgloveChannel>& channels, std::size_t first) {
    json told = {{"op", "advertise"}, {"channels", json::array()}};
    for (std::size_t i = first; i < channels.size(); ++i) {
        told["channels"].push_back({{"id", i + 1},
                                    {"topic", channels[i].topic},
                                    {"encoding", "json"},
                                    {"schemaName", channels[i].schema_name},
                                    {"schema", channels[i].schema},
                                    {"schemaEncoding", "jsonschema"}});
    }
    return told;
}

}  // namespace

struct FoxgloveServer::Impl {
    std::string name, token, session;
    lws_protocols protocols[2] = {};
    lws_context* context = nullptr;
    int port = 0;
    std::atomic<bool> stopping{false};
    std::thread thread;

    mutable std::mutex mutex;  // guards what follows
    std::vector<FoxgloveChannel> channels;
    std::map<std::size_t, Message> last;  // of latched channels
    std::map<lws*, Client> clients;
    long missed = 0;

    static int on_event(lws* socket, lws_callback_reasons reason, void*, void* bytes, std::size_t size);
    bool may_enter(lws* socket);
    void greet(lws* socket);
    bool receive(lws* socket, std::string_view bytes);
    bool write(lws* socket);
    void take(Client& client, const std::string& text);
    void subscribe(Client& client, const FoxgloveRequest::Subscription& wish);
    void queue(Client& client, Frame frame);
    void complain(Client& client, const std::string& message);
};

int FoxgloveServer::Impl::on_event(lws* socket, lws_callback_reasons reason, void*, void* bytes, std::size_t size) {
    Impl& self = *static_cast<Impl*>(lws_context_user(lws_get_context(socket)));
    switch (reason) {
        case LWS_CALLBACK_FILTER_PROTOCOL_CONNECTION:
            return self.may_enter(socket) ? 0 : 1;
        case LWS_CALLBACK_ESTABLISHED:
            self.greet(socket);
            return 0;
        case LWS_CALLBACK_RECEIVE:
            return self.receive(socket, {static_cast<const char*>(bytes), size}) ? 0 : -1;
        case LWS_CALLBACK_SERVER_WRITEABLE:
            return self.write(socket) ? 0 : -1;
        case LWS_CALLBACK_EVENT_WAIT_CANCELLED:
            lws_callback_on_writable_all_protocol(lws_get_context(socket), self.protocols);
            return 0;
        case LWS_CALLBACK_CLOSED: {
            const std::lock_guard lock(self.mutex);
            self.clients.erase(socket);
            return 0;
        }
        case LWS_CALLBACK_HTTP:
            return lws_return_http_status(socket, HTTP_STATUS_BAD_REQUEST, "This is for Foxglove, by WebSocket.");
        default:
            return 0;
    }
}

bool FoxgloveServer::Impl::may_enter(lws* socket) {
    {
        const std::lock_guard lock(mutex);
        if (clients.size() >= most_clients) return false;
    }
    if (token.empty()) return true;
    char text[512] = "";
    if (const char* given = lws_get_urlarg_by_name(socket, "token=", text, sizeof(text)); given && same_token(given, token)) return true;
    return lws_hdr_copy(socket, text, sizeof(text), WSI_TOKEN_HTTP_AUTHORIZATION) > 0 && shows_token(text, token);
}

void FoxgloveServer::Impl::greet(lws* socket) {
    const std::lock_guard lock(mutex);
    Client& client = clients[socket];
    const json info = {{"op", "serverInfo"},         {"name", name},        {"capabilities", json::array()}, {"supportedEncodings", json::array()},
                       {"metadata", json::object()}, {"sessionId", session}};
    queue(client, Frame(json_line(info)));
    queue(client, Frame(json_line(advertisement(channels, 0))));
    lws_callback_on_writable(socket);
}

bool FoxgloveServer::Impl::receive(lws* socket, std::string_view bytes) {
    const std::lock_guard lock(mutex);
    Client& client = clients[socket];
    client.request += bytes;
    if (client.request.size() > longest_request) return false;
    if (!lws_is_final_fragment(socket) || lws_remaining_packet_payload(socket) > 0) return true;
    take(client, std::exchange(client.request, ""));
    lws_callback_on_writable(socket);
    return !client.hopeless;
}

/// The mutex is held, here and in all that follows but write().
void FoxgloveServer::Impl::take(Client& client, const std::string& text) {
    const FoxgloveRequest request = parse_foxglove_request(text, channels.size());
    for (const std::string& problem : request.problems) complain(client, problem);
    for (const FoxgloveRequest::Subscription& wish : request.subscribe) subscribe(client, wish);
    for (const std::uint32_t id : request.unsubscribe) client.subscriptions.erase(id);
}

void FoxgloveServer::Impl::subscribe(Client& client, const FoxgloveRequest::Subscription& wish) {
    if (client.subscriptions.size() >= most_subscriptions) return complain(client, "there are too many subscriptions");
    const std::size_t channel = wish.channel - 1;
    client.subscriptions[wish.id] = channel;
    if (const auto found = last.find(channel); found != last.end()) queue(client, data_frame(wish.id, found->second.time, found->second.json));
}

void FoxgloveServer::Impl::complain(Client& client, const std::string& message) {
    queue(client, Frame(json_line(json{{"op", "status"}, {"level", 2}, {"message", message}})));
}

void FoxgloveServer::Impl::queue(Client& client, Frame frame) {
    client.waiting_bytes += frame.size();
    client.waiting.push_back(std::move(frame));
    // Texts are kept: without an advertisement a client would not know what comes.
    for (auto oldest = client.waiting.begin(); client.waiting_bytes > most_waiting && oldest != client.waiting.end();) {
        if (oldest->is_text()) {
            ++oldest;
            continue;
        }
        client.waiting_bytes -= oldest->size();
        oldest = client.waiting.erase(oldest);
        ++missed;
    }
    client.hopeless |= client.waiting_bytes > most_waiting;
}

/// The next frame that waits; the library calls again when there is room for another.
bool FoxgloveServer::Impl::write(lws* socket) {
    std::optional<Frame> frame;
    bool more = false;
    {
        const std::lock_guard lock(mutex);
        Client& client = clients[socket];
        if (client.waiting.empty()) return true;
        frame = std::move(client.waiting.front());
        client.waiting.pop_front();
        client.waiting_bytes -= frame->size();
        more = !client.waiting.empty();
    }
    const int written = lws_write(socket, frame->data(), frame->size(), frame->is_text() ? LWS_WRITE_TEXT : LWS_WRITE_BINARY);
    if (more) lws_callback_on_writable(socket);
    return written >= static_cast<int>(frame->size());
}

FoxgloveServer::FoxgloveServer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {
    impl_->thread = std::thread([this] {
        while (!impl_->stopping && lws_service(impl_->context, 0) >= 0) {
        }
    });
}

FoxgloveServer::~FoxgloveServer() {
    impl_->stopping = true;
    lws_cancel_service(impl_->context);
    impl_->thread.join();
    lws_context_destroy(impl_->context);
}

Result<std::unique_ptr<FoxgloveServer>> FoxgloveServer::start(const WebAccess& access, const std::string& name) {
    auto impl = std::make_unique<Impl>();
    impl->name = name;
    impl->token = access.token;
    impl->session = std::to_string(system_now());
    impl->protocols[0] = {subprotocol, &Impl::on_event, 0, 4096, 0, nullptr, 0};
    lws_set_log_level(0, nullptr);
    lws_context_creation_info info = {};
    info.port = access.port;
    info.iface = access.host == "0.0.0.0" || access.host == "::" ? nullptr : access.host.c_str();
    info.protocols = impl->protocols;
    info.user = impl.get();
    info.options = LWS_SERVER_OPTION_FAIL_UPON_UNABLE_TO_BIND | LWS_SERVER_OPTION_VALIDATE_UTF8;
    if (access.host.find(':') == std::string::npos) info.options |= LWS_SERVER_OPTION_DISABLE_IPV6;
    if (!access.certificate.empty()) {
        info.options |= LWS_SERVER_OPTION_DO_SSL_GLOBAL_INIT;
        info.ssl_cert_filepath = access.certificate.c_str();
        info.ssl_private_key_filepath = access.key.c_str();
    }
    impl->context = lws_create_context(&info);
    if (!impl->context) {
        return Error{fmt::format("Foxglove's server cannot listen at {}:{}: another program may have the port{}", access.host, access.port,
                                 access.certificate.empty() ? "" : ", or its certificate and key cannot be read or do not belong together")};
    }
    impl->port = lws_get_vhost_listen_port(lws_get_vhost_by_name(impl->context, "default"));
    return std::unique_ptr<FoxgloveServer>(new FoxgloveServer(std::move(impl)));
}

int FoxgloveServer::port() const { return impl_->port; }

std::size_t FoxgloveServer::add_channel(const FoxgloveChannel& channel) {
    std::size_t number = 0;
    {
        const std::lock_guard lock(impl_->mutex);
        number = impl_->channels.size();
        impl_->channels.push_back(channel);
        const std::string told = json_line(advertisement(impl_->channels, number));
        for (auto& [socket, client] : impl_->clients) impl_->queue(client, Frame(told));
    }
    lws_cancel_service(impl_->context);
    return number;
}

bool FoxgloveServer::is_wanted(std::size_t channel) const {
    const std::lock_guard lock(impl_->mutex);
    return std::any_of(impl_->clients.begin(), impl_->clients.end(), [&](const auto& client) {
        const auto& wished = client.second.subscriptions;
        return std::any_of(wished.begin(), wished.end(), [&](const auto& one) { return one.second == channel; });
    });
}

void FoxgloveServer::send(std::size_t channel, Nanoseconds time, std::string json) {
    {
        const std::lock_guard lock(impl_->mutex);
        for (auto& [socket, client] : impl_->clients) {
            for (const auto& [subscription, wished] : client.subscriptions) {
                if (wished == channel) impl_->queue(client, data_frame(subscription, time, json));
            }
        }
        if (impl_->channels[channel].latched) impl_->last[channel] = {time, std::move(json)};
    }
    lws_cancel_service(impl_->context);
}

long FoxgloveServer::missed() const {
    const std::lock_guard lock(impl_->mutex);
    return impl_->missed;
}

}  // namespace roomfix

#else

namespace roomfix {

struct FoxgloveServer::Impl {};

FoxgloveServer::FoxgloveServer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
FoxgloveServer::~FoxgloveServer() = default;
Result<std::unique_ptr<FoxgloveServer>> FoxgloveServer::start(const WebAccess&, const std::string&) {
    return Error{"this roomfix was built without Foxglove's server: install libwebsockets-dev and build it again, or take 'foxglove' out of the site file"};
}
int FoxgloveServer::port() const { return 0; }
std::size_t FoxgloveServer::add_channel(const FoxgloveChannel&) { return 0; }
bool FoxgloveServer::is_wanted(std::size_t) const { return false; }
void FoxgloveServer::send(std::size_t, Nanoseconds, std::string) {}
long FoxgloveServer::missed() const { return 0; }

}  // namespace roomfix

#endif
