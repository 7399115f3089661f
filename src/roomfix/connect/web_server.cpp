#include "roomfix/connect/web_server.hpp"

#include <fmt/format.h>
#include <httplib.h>
#include <sys/socket.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <map>
#include <mutex>
#include <thread>

#include "roomfix/connect/connection_threads.hpp"

namespace roomfix {
namespace {

constexpr std::size_t most_connections = 600;
constexpr int most_event_streams = 400;   // the rest is left for questions that are answered at once
constexpr int waiting_connections = 512;  // that the system keeps until they are accepted
constexpr int patience = 5;               // s: for a request to come, and for a client to take its answer
constexpr std::size_t largest_body = 64 * 1024;

}  // namespace

struct WebServer::Impl {
    std::unique_ptr<httplib::Server> server;
    std::thread thread;
    socket_t socket = INVALID_SOCKET;
    int port = 0;
    std::atomic<int> event_streams{0};

    std::mutex mutex;  // guards what follows
    std::condition_variable changed;
    std::string site = "{}";
    std::shared_ptr<const std::string> state = std::make_shared<const std::string>("{}");
    std::uint64_t version = 0;
    bool stopping = false;
    std::function<std::vector<std::uint8_t>(const std::string&)> picture;
    std::map<std::string, WebAnswerer> added;  // by their paths

    bool write_event(httplib::DataSink& sink, std::uint64_t& seen);
    void answer_events(httplib::Response& response);
    void answer_picture(const std::string& camera, httplib::Response& response);
    void answer_added(const httplib::Request& request, httplib::Response& response);
    void set_limits();
    void ask_for(const std::string& token);
    void add_routes();
    void add_page();
};

/// Waits for a state newer than `seen` and writes it as one event; a comment every few seconds keeps proxies awake.
bool WebServer::Impl::write_event(httplib::DataSink& sink, std::uint64_t& seen) {
    std::shared_ptr<const std::string> newest;
    {
        std::unique_lock lock(mutex);
        const bool news = changed.wait_for(lock, std::chrono::seconds(5), [&] { return stopping || version != seen; });
        if (stopping) return false;
        if (news) newest = state;
        seen = version;
    }
    const std::string event = newest ? "event: state\ndata: " + *newest + "\n\n" : ": still here\n\n";
    return sink.write(event.data(), event.size());
}

void WebServer::Impl::answer_events(httplib::Response& response) {
    if (++event_streams > most_event_streams) {
        --event_streams;
        response.status = 503;
        response.set_content("there are too many listeners; ask /api/state instead\n", "text/plain");
        return;
    }
    response.set_header("Cache-Control", "no-cache");
    auto seen = std::make_shared<std::uint64_t>(0);
    response.set_chunked_content_provider(
        "text/event-stream", [this, seen](std::size_t, httplib::DataSink& sink) { return write_event(sink, *seen); }, [this](bool) { --event_streams; });
}

void WebServer::Impl::answer_picture(const std::string& camera, httplib::Response& response) {
    std::function<std::vector<std::uint8_t>(const std::string&)> source;
    {
        const std::lock_guard lock(mutex);
        source = picture;
    }
    const auto bytes = source ? source(camera) : std::vector<std::uint8_t>();
    if (bytes.empty()) {
        response.status = 404;
        response.set_content("no picture of this camera yet\n", "text/plain");
        return;
    }
    response.set_header("Cache-Control", "no-store");
    response.set_content(reinterpret_cast<const char*>(bytes.data()), bytes.size(), "image/jpeg");
}

/// What nobody else answers.
void WebServer::Impl::answer_added(const httplib::Request& request, httplib::Response& response) {
    WebAnswerer answerer;
    {
        const std::lock_guard lock(mutex);
        if (const auto found = added.find(request.path); found != added.end()) answerer = found->second;
    }
    WebAnswer answer{404, "text/plain", "there is nothing at this address\n"};
    if (answerer) answer = answerer(request.params);
    response.status = answer.status;
    response.set_content(std::move(answer.body), answer.type);
}

void WebServer::Impl::add_page() {
    for (const EmbeddedFile& file : page_files()) {
        const auto serve = [&file](const httplib::Request&, httplib::Response& response) {
            response.set_content(reinterpret_cast<const char*>(file.data), file.size, file.type);
        };
        server->Get(file.path, serve);
        if (std::string_view(file.path) == "/index.html") server->Get("/", serve);
    }
    if (!page_files().empty()) return;
    server->Get("/", [](const httplib::Request&, httplib::Response& response) {
        response.set_content("This roomfix was built without its page (ROOMFIX_PAGE=OFF). The data is at /api/state and /api/events.\n", "text/plain");
    });
}

void WebServer::Impl::add_routes() {
    server->Get("/api/site", [this](const httplib::Request&, httplib::Response& response) {
        const std::lock_guard lock(mutex);
        response.set_content(site, "application/json");
    });
    server->Get("/api/state", [this](const httplib::Request&, httplib::Response& response) {
        const std::lock_guard lock(mutex);
        response.set_content(*state, "application/json");
    });
    server->Get("/api/events", [this](const httplib::Request&, httplib::Response& response) { answer_events(response); });
    server->Get(R"(/api/cameras/([A-Za-z0-9_-]+)\.jpg)",
                [this](const httplib::Request& request, httplib::Response& response) { answer_picture(request.matches[1], response); });
}

void WebServer::Impl::set_limits() {
    server->new_task_queue = [] { return new ConnectionThreads(most_connections); };
    server->set_read_timeout(patience);
    server->set_write_timeout(patience);
    server->set_keep_alive_timeout(patience);
    server->set_payload_max_length(largest_body);
    // Without SO_REUSEPORT, which httplib sets by default: a second roomfix on the same port must be an error.
    server->set_socket_options([this](socket_t listening) {
        const int yes = 1;
        setsockopt(listening, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof(yes));
        socket = listening;
    });
    server->set_default_headers({{"X-Content-Type-Options", "nosniff"}});
}

/// Who does not show the token gets no answer but where to put it.
void WebServer::Impl::ask_for(const std::string& token) {
    server->set_pre_routing_handler([token](const httplib::Request& request, httplib::Response& response) {
        if (shows_token(request.get_header_value("Authorization"), token)) return httplib::Server::HandlerResponse::Unhandled;
        response.status = 401;
        response.set_header("WWW-Authenticate", "Basic realm=\"roomfix: any name, the token as password\"");
        response.set_content("a token is needed\n", "text/plain");
        return httplib::Server::HandlerResponse::Handled;
    });
}

WebServer::WebServer() : impl_(std::make_unique<Impl>()) {}

WebServer::~WebServer() { stop(); }

void WebServer::set_site(std::string json) {
    const std::lock_guard lock(impl_->mutex);
    impl_->site = std::move(json);
}

void WebServer::set_picture_source(std::function<std::vector<std::uint8_t>(const std::string&)> source) {
    const std::lock_guard lock(impl_->mutex);
    impl_->picture = std::move(source);
}

void WebServer::add_route(const std::string& path, WebAnswerer answerer) {
    const std::lock_guard lock(impl_->mutex);
    impl_->added[path] = std::move(answerer);
}

Result<void> WebServer::start(const WebAccess& access) {
    if (access.certificate.empty()) {
        impl_->server = std::make_unique<httplib::Server>();
    } else {
        impl_->server = std::make_unique<httplib::SSLServer>(access.certificate.c_str(), access.key.c_str());
        if (!impl_->server->is_valid()) {
            return Error{
                fmt::format("the page's certificate {} with its key {} cannot be used: check that both are PEM files that can be read and that they "
                            "belong together",
                            access.certificate, access.key)};
        }
    }
    impl_->set_limits();
    if (!access.token.empty()) impl_->ask_for(access.token);
    impl_->add_routes();
    impl_->add_page();
    impl_->server->Get(".*", [impl = impl_.get()](const httplib::Request& request, httplib::Response& response) { impl->answer_added(request, response); });
    if (access.port == 0) {
        impl_->port = impl_->server->bind_to_any_port(access.host);
    } else {
        impl_->port = impl_->server->bind_to_port(access.host, access.port) ? access.port : -1;
    }
    if (impl_->port <= 0) {
        return Error{fmt::format("port {} on {} cannot be used: another program may have it (perhaps another roomfix); choose one with --port", access.port,
                                 access.host)};
    }
    ::listen(impl_->socket, waiting_connections);  // httplib's own limit is 5
    impl_->thread = std::thread([this] { impl_->server->listen_after_bind(); });
    while (!impl_->server->is_running()) std::this_thread::sleep_for(std::chrono::milliseconds(2));
    return {};
}

int WebServer::port() const { return impl_->port; }

void WebServer::publish(std::string json) {
    auto newest = std::make_shared<const std::string>(std::move(json));
    {
        const std::lock_guard lock(impl_->mutex);
        impl_->state = std::move(newest);
        ++impl_->version;
    }
    impl_->changed.notify_all();
}

void WebServer::stop() {
    {
        const std::lock_guard lock(impl_->mutex);
        impl_->stopping = true;
    }
    impl_->changed.notify_all();
    if (impl_->server) impl_->server->stop();
    if (impl_->thread.joinable()) impl_->thread.join();
}

}  // namespace roomfix
