// Where a site's fixes go, as its file says it: plain values.
#pragma once

#include <optional>
#include <string>

namespace roomfix {

/// A password or token that does not stand in the site file: the first line of a file, or an environment variable.
struct Secret {
    std::string file;      // relative to the site file; empty: the variable
    std::string variable;  // of the environment
};

/// Files in PEM format, relative to the site file; empty where there is none.
struct TlsFiles {
    std::string ca;           // whom to believe; empty: the system's
    std::string certificate;  // one's own
    std::string key;
};

/// Where a server of this program listens, and who may ask it.
struct WebOutput {
    std::string host = "127.0.0.1";
    int port = 8080;
    std::optional<TlsFiles> tls;           // none: not encrypted
    std::optional<Secret> token;           // that whoever looks must know
    std::optional<Secret> operator_token;  // that whoever changes something must know; none: nothing can be changed
    bool insecure = false;                 // others may look without either
};

/// Does this address lead to this machine only?
bool is_loopback(const std::string& host);
/// Why `what` must not listen so; empty if it may.
std::string refusal(const WebOutput& web, const std::string& what);

struct MqttOutput {
    std::string host = "127.0.0.1";
    int port = 1883;
    std::string prefix = "roomfix";  // topics are PREFIX/SITE/ROBOT/...
    std::string user;
    std::optional<Secret> password;
    std::optional<TlsFiles> tls;  // none: not encrypted
    double rate = 10;             // Hz, poses of each robot; 0: all
    bool home_assistant = false;  // tell Home Assistant what there is
};

/// ROS 2 topics over DDS.
struct Ros2Output {
    int domain = 0;
    bool robot_transform = false;  // `map -> ROBOT/base_link` for robots without odometry of their own
};

struct HistoryOutput {
    std::string database = "history.db";  // an SQLite file, or postgresql://...
    double days = 30;                     // how long fixes are kept
};

struct Outputs {
    std::optional<WebOutput> web;
    std::string jsonl;  // file for fixes; empty: none
    std::string tum;    // folder for each robot's way as evo reads it; empty: none
    std::optional<MqttOutput> mqtt;
    std::optional<Ros2Output> ros2;
    std::optional<HistoryOutput> history;
    std::optional<WebOutput> foxglove;
};

}  // namespace roomfix
