// The page and its data over HTTP: files, JSON, server-sent events, the cameras' pictures.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "roomfix/connect/web_access.hpp"
#include "roomfix/connect/web_answer.hpp"

namespace roomfix {

/// A file that is part of the program.
struct EmbeddedFile {
    const char* path;  // as asked for, "/index.html"
    const char* type;  // MIME type
    const unsigned char* data;
    std::size_t size;
};

/// The built page; empty if the program was built without it.
const std::vector<EmbeddedFile>& page_files();

/// docs/openapi.json, which is part of the program.
std::string_view openapi_text();

/// Serves GET / and the page's files, and the routes of web_routes.hpp: by itself /api/site, /api/state, /api/events (a "state" event whenever publish() is
/// called), /api/access and /api/openapi.json, the others once they are added. What is not a GET changes something: only the operator may, and no other site's
/// page. Requests are bounded in size and time, connections and event streams in number: slow and idle clients hold up nobody else.
class WebServer {
public:
    WebServer();
    ~WebServer();
    WebServer(const WebServer&) = delete;
    WebServer& operator=(const WebServer&) = delete;

    /// What /api/site answers.
    void set_site(std::string json);
    /// `route` is one of web_routes; `answerer` is called from several threads at once.
    void add_route(const std::string& route, WebAnswerer answerer);

    /// Starts serving in threads of its own. An error if the address is taken or not ours, or the certificate cannot be used.
    Result<void> start(const WebAccess& access);
    int port() const;
    /// A new state for /api/state and all listeners of /api/events.
    void publish(std::string json);
    void stop();

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace roomfix
