// A server of Foxglove's WebSocket protocol (subprotocol foxglove.websocket.v1): messages on topics to whoever looks.
#pragma once

#include <cstddef>
#include <memory>
#include <string>

#include "roomfix/base/result.hpp"
#include "roomfix/base/time.hpp"
#include "roomfix/connect/web_access.hpp"

namespace roomfix {

/// A topic of JSON messages.
struct FoxgloveChannel {
    std::string topic;
    std::string schema_name;  // "foxglove.PoseInFrame"
    std::string schema;       // JSON Schema, as text
    bool latched = false;     // who subscribes gets the last message at once
};

/// Works in a thread of its own. A client that does not keep up misses its oldest messages; nobody else notices. All functions may be called from any thread.
class FoxgloveServer {
public:
    /// `name` is what clients show. A token is part of the address that clients are given: ws://HOST:PORT/?token=TOKEN. An error where the port is taken or
    /// not ours, the certificate cannot be used, or roomfix was built without it.
    static Result<std::unique_ptr<FoxgloveServer>> start(const WebAccess& access, const std::string& name);
    ~FoxgloveServer();
    FoxgloveServer(const FoxgloveServer&) = delete;
    FoxgloveServer& operator=(const FoxgloveServer&) = delete;

    int port() const;
    /// Its number, for send().
    std::size_t add_channel(const FoxgloveChannel& channel);
    /// Does anybody listen?
    bool is_wanted(std::size_t channel) const;
    /// `time` of what the message says.
    void send(std::size_t channel, Nanoseconds time, std::string json);
    /// Messages that clients missed.
    long missed() const;

private:
    struct Impl;
    explicit FoxgloveServer(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

}  // namespace roomfix
