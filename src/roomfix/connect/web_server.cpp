#include "roomfix/connect/web_server.hpp"

#include <fmt/format.h>
#include <httplib.h>

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>

namespace roomfix {

struct WebServer::Impl {
    httplib::Server server;
    std::thread thread;
    int port = 0;

    std::mutex mutex;  // guards what follows
    std::condition_variable changed;
    std::string site = "{}";
    std::string state = "{}";
    std::uint64_t version = 0;
    bool stopping = false;
    std::function<std::vector<std::uint8_t>(const std::string&)> picture;

    /// Waits for a state newer than `seen` and writes it as one event; a comment every few seconds keeps proxies awake.
    bool write_event(httplib::DataSink& sink, std::uint64_t& seen) {
        std::string event;
        {
            std::unique_lock lock(mutex);
            const bool news = changed.wait_for(lock, std::chrono::seconds(5), [&] { return stopping || version != seen; });
            if (stopping) return false;
            event = news ? "event: state\ndata: " + state + "\n\n" : ": still here\n\n";
            seen = version;
        }
        return sink.write(event.data(), event.size());
    }

    void add_routes() {
        server.Get("/api/site", [this](const httplib::Request&, httplib::Response& response) {
            const std::lock_guard lock(mutex);
            response.set_content(site, "application/json");
        });
        server.Get("/api/state", [this](const httplib::Request&, httplib::Response& response) {
            const std::lock_guard lock(mutex);
            response.set_content(state, "application/json");
        });
        server.Get("/api/events", [this](const httplib::Request&, httplib::Response& response) {
            response.set_header("Cache-Control", "no-cache");
            auto seen = std::make_shared<std::uint64_t>(0);
            response.set_chunked_content_provider("text/event-stream", [this, seen](std::size_t, httplib::DataSink& sink) { return write_event(sink, *seen); });
        });
        server.Get(R"(/api/cameras/([A-Za-z0-9_-]+)\.jpg)", [this](const httplib::Request& request, httplib::Response& response) {
            std::function<std::vector<std::uint8_t>(const std::string&)> source;
            {
                const std::lock_guard lock(mutex);
                source = picture;
            }
            const auto bytes = source ? source(request.matches[1]) : std::vector<std::uint8_t>();
            if (bytes.empty()) {
                response.status = 404;
                response.set_content("no picture of this camera yet\n", "text/plain");
                return;
            }
            response.set_header("Cache-Control", "no-store");
            response.set_content(reinterpret_cast<const char*>(bytes.data()), bytes.size(), "image/jpeg");
        });
        for (const EmbeddedFile& file : page_files()) {
            const auto serve = [&file](const httplib::Request&, httplib::Response& response) {
                response.set_content(reinterpret_cast<const char*>(file.data), file.size, file.type);
            };
            server.Get(file.path, serve);
            if (std::string_view(file.path) == "/index.html") server.Get("/", serve);
        }
        if (page_files().empty()) {
            server.Get("/", [](const httplib::Request&, httplib::Response& response) {
                response.set_content("This roomfix was built without its page (ROOMFIX_PAGE=OFF). The data is at /api/state and /api/events.\n", "text/plain");
            });
        }
    }
};

WebServer::WebServer() : impl_(std::make_unique<Impl>()) {
    impl_->server.new_task_queue = [] { return new httplib::ThreadPool(32); };  // an open page holds one for its events
    // Without SO_REUSEPORT, which httplib sets by default: a second roomfix on the same port must be an error.
    impl_->server.set_socket_options([](socket_t socket) {
        const int yes = 1;
        setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof(yes));
    });
    impl_->server.set_default_headers({{"X-Content-Type-Options", "nosniff"}});
    impl_->add_routes();
}

WebServer::~WebServer() { stop(); }

void WebServer::set_site(std::string json) {
    const std::lock_guard lock(impl_->mutex);
    impl_->site = std::move(json);
}

void WebServer::set_picture_source(std::function<std::vector<std::uint8_t>(const std::string&)> source) {
    const std::lock_guard lock(impl_->mutex);
    impl_->picture = std::move(source);
}

Result<void> WebServer::start(const std::string& host, int port) {
    if (port == 0) {
        impl_->port = impl_->server.bind_to_any_port(host);
    } else {
        impl_->port = impl_->server.bind_to_port(host, port) ? port : -1;
    }
    if (impl_->port <= 0) {
        return Error{fmt::format("port {} on {} cannot be used: another program may have it (perhaps another roomfix); choose one with --port", port, host)};
    }
    impl_->thread = std::thread([this] { impl_->server.listen_after_bind(); });
    while (!impl_->server.is_running()) std::this_thread::sleep_for(std::chrono::milliseconds(2));
    return {};
}

int WebServer::port() const { return impl_->port; }

void WebServer::publish(std::string json) {
    {
        const std::lock_guard lock(impl_->mutex);
        impl_->state = std::move(json);
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
    impl_->server.stop();
    if (impl_->thread.joinable()) impl_->thread.join();
}

}  // namespace roomfix
