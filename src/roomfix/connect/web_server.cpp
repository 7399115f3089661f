#include "roomfix/connect/web_server.hpp"

#include <fmt/format.h>
#include <httplib.h>
#include <sys/socket.h>

#include <algorithm>
#include <atomic>
#include <cassert>
#include <chrono>
#include <condition_variable>
#include <map>
#include <mutex>
#include <optional>
#include <string_view>
#include <thread>

#include "roomfix/connect/connection_threads.hpp"
#include "roomfix/connect/web_routes.hpp"

namespace roomfix {
namespace {

constexpr std::size_t most_connections = 600;
constexpr int most_event_streams = 400;   // the rest is left for questions that are answered at once
constexpr int waiting_connections = 512;  // that the system keeps until they are accepted
constexpr int patience = 5;               // s: for a request to come, and for a client to take its answer
constexpr std::size_t largest_body = 64 * 1024;

using Handled = httplib::Server::HandlerResponse;

/// Answers before the body has been read: what comes of it would be taken for the next request, so the connection ends.
Handled end_with(httplib::Response& response, int status, const std::string& text) {
    response.status = status;
    response.set_header("Connection", "close");
    response.set_content_provider(text.size(), "text/plain", [text](std::size_t, std::size_t, httplib::DataSink& sink) {
        (void)sink.write(text.data(), text.size());
        return false;
    });
    return Handled::Handled;
}

/// Bodies whose length is not told, or that become longer than they are, have no limit.
bool has_body_without_limit(const httplib::Request& request) {
    const bool may_have_body = request.method == "PUT" || request.method == "POST" || request.method == "PATCH";
    return request.has_header("Transfer-Encoding") || request.has_header("Content-Encoding") || (may_have_body && !request.has_header("Content-Length"));
}

}  // namespace

struct WebServer::Impl {
    WebAccess access;
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
    std::map<std::string, WebAnswerer> answerers;  // by their routes

    Impl();
    bool write_event(httplib::DataSink& sink, std::uint64_t& seen);
    void answer_events(httplib::Response& response);
    WebAnswer answer_access(WebRole role);
    Handled look_at(const httplib::Request& request, httplib::Response& response) const;
    bool refuse_change(const httplib::Request& request, WebRole role, httplib::Response& response) const;
    void answer(const httplib::Request& request, httplib::Response& response);
    WebAnswer answer_none(const std::string& path, httplib::Response& response);
    void set_limits();
    void add_routes();
    void add_page();
};

WebServer::Impl::Impl() {
    answerers["GET /api/openapi.json"] = [](const WebQuestion&) { return WebAnswer{200, "application/json", std::string(openapi_text())}; };
    answerers["GET /api/access"] = [this](const WebQuestion& question) { return answer_access(question.role); };
    answerers["GET /api/site"] = [this](const WebQuestion&) {
        const std::lock_guard lock(mutex);
        return WebAnswer{200, "application/json", site};
    };
    answerers["GET /api/state"] = [this](const WebQuestion&) {
        const std::lock_guard lock(mutex);
        return WebAnswer{200, "application/json", *state};
    };
}

/// Waits for a state newer than `seen` and writes it as one event; a comment every few seconds keeps proxies awake.
bool WebServer::Impl::write_event(httplib::DataSink& sink, std::uint64_t& seen) {
    std::shared_ptr<const std::string> newest;
    const bool first = seen == 0;
    {
        std::unique_lock lock(mutex);
        const bool news = changed.wait_for(lock, std::chrono::seconds(5), [&] { return stopping || version != seen; });
        if (stopping) return false;
        if (news) newest = state;
        seen = version;
    }
    std::string event = newest ? "event: state\ndata: " + *newest + "\n\n" : ": still here\n\n";
    if (first) event.insert(0, "retry: 1000\n");  // ms until a browser that lost us tries again
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

WebAnswer WebServer::Impl::answer_access(WebRole role) {
    const std::lock_guard lock(mutex);
    const bool operators = !access.operator_token.empty() && answerers.contains("PUT /api/zones/{id}");
    return {200, "application/json", fmt::format(R"({{"role":"{}","operators":{}}})", role == WebRole::operating ? "operator" : "viewer", operators)};
}

/// Before anything else: who does not show the token gets no answer but where to put it.
Handled WebServer::Impl::look_at(const httplib::Request& request, httplib::Response& response) const {
    if (role_of(access, request.get_header_value("Authorization")) == WebRole::nobody) {
        response.set_header("WWW-Authenticate", "Basic realm=\"roomfix: any name, the token as password\"");
        return end_with(response, 401, "a token is needed\n");
    }
    if (has_body_without_limit(request)) return end_with(response, 411, "the length of the body must be told, and it must not be compressed\n");
    return Handled::Unhandled;
}

/// Says why, if this request must not change anything.
bool WebServer::Impl::refuse_change(const httplib::Request& request, WebRole role, httplib::Response& response) const {
    std::string reason = "nothing can be changed here: the site file names no operator (outputs.web.operator)\n";
    response.status = 403;
    if (!access.operator_token.empty()) {
        const std::string type = request.get_header_value("Content-Type");
        const bool body = request.method == "PUT" || !request.body.empty();
        reason = foreign_change({request.get_header_value("Origin"), request.get_header_value("Host"), body ? std::optional(type) : std::nullopt});
        if (role == WebRole::operating && reason.empty()) return false;
        if (role != WebRole::operating) {
            reason = "only the operator may change this: the operator's token is needed";
            if (access.token.empty()) response.status = 401;
            response.set_header("WWW-Authenticate", "Bearer realm=\"roomfix: the operator's token\"");
        }
        reason += '\n';
    }
    response.set_content(reason, "text/plain");
    return true;
}

/// The path of no route, or asked for in another way than it can be.
WebAnswer WebServer::Impl::answer_none(const std::string& path, httplib::Response& response) {
    std::string methods;
    for (const auto& [route, answerer] : answerers) {
        if (id_in(path, route)) methods += (methods.empty() ? "" : ", ") + route.substr(0, route.find(' '));
    }
    if (methods.empty()) return {404, "text/plain", "there is nothing at this address\n"};
    response.set_header("Allow", methods);
    return {405, "text/plain", fmt::format("this address takes {} only\n", methods)};
}

void WebServer::Impl::answer(const httplib::Request& request, httplib::Response& response) {
    WebQuestion question{request.params, "", request.body, role_of(access, request.get_header_value("Authorization"))};
    const std::string method = request.method == "HEAD" ? "GET" : request.method;
    WebAnswerer answerer;
    WebAnswer answer;
    {
        const std::lock_guard lock(mutex);
        for (const auto& [route, candidate] : answerers) {
            const auto id = route.starts_with(method + " ") ? id_in(request.path, route) : std::nullopt;
            if (!id) continue;
            answerer = candidate;
            question.id = *id;
        }
        if (!answerer) answer = answer_none(request.path, response);
    }
    if (answerer) {
        if (method != "GET" && refuse_change(request, question.role, response)) return;
        answer = answerer(question);
    }
    response.status = answer.status;
    response.set_header("Cache-Control", "no-store");
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
    server->set_pre_routing_handler([this](const httplib::Request& request, httplib::Response& response) { return look_at(request, response); });
    add_page();
    server->Get("/api/events", [this](const httplib::Request&, httplib::Response& response) { answer_events(response); });
    const auto other = [this](const httplib::Request& request, httplib::Response& response) { answer(request, response); };
    server->Get(".*", other).Put(".*", other).Delete(".*", other).Post(".*", other).Patch(".*", other);
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

WebServer::WebServer() : impl_(std::make_unique<Impl>()) {}

WebServer::~WebServer() { stop(); }

void WebServer::set_site(std::string json) {
    const std::lock_guard lock(impl_->mutex);
    impl_->site = std::move(json);
}

void WebServer::add_route(const std::string& route, WebAnswerer answerer) {
    assert(std::find(web_routes.begin(), web_routes.end(), route) != web_routes.end());
    const std::lock_guard lock(impl_->mutex);
    impl_->answerers[route] = std::move(answerer);
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
    impl_->access = access;
    impl_->set_limits();
    impl_->add_routes();
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
