// The page and its data over HTTP: files, JSON, server-sent events, the cameras' pictures.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
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

/// Serves GET / and the page's files, /api/site, /api/state, /api/events (a "state" event whenever publish() is called), /api/cameras/ID.jpg and what is added.
/// Answers only; nothing can be changed through it. Requests are bounded in size and time, connections and event streams in number: slow and idle clients
/// hold up nobody else.
class WebServer {
public:
    WebServer();
    ~WebServer();
    WebServer(const WebServer&) = delete;
    WebServer& operator=(const WebServer&) = delete;

    /// What /api/site answers.
    void set_site(std::string json);
    /// Called for /api/cameras/ID.jpg; an empty answer means there is no such picture (yet).
    void set_picture_source(std::function<std::vector<std::uint8_t>(const std::string& camera)> source);
    /// `answerer` is called for a path such as /metrics, from several threads at once.
    void add_route(const std::string& path, WebAnswerer answerer);

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
