// Readings that come as they come, from serial lines, UDP, MQTT and ROS 2, into a tracker.
#pragma once

#include <atomic>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "roomfix/connect/mqtt_client.hpp"
#include "roomfix/connect/sense_lines.hpp"
#include "roomfix/pipeline/site_tracker.hpp"

namespace roomfix {

/// How a source of readings fares.
struct SenseState {
    std::string source;   // as the site file names it
    std::string message;  // what is wrong with it, or how its senders' clocks differ from ours
    long readings = 0;    // that were used
};

/// Kinds of sources that give readings as they come: /dev/..., udp://HOST:PORT, mqtt:TOPIC, ros2:/TOPIC (`is_ros_topic`).
bool is_serial_line(const std::string& source);
bool is_udp_address(const std::string& source);
bool is_mqtt_topic(const std::string& source);
/// Any of them.
bool is_live_sense(const std::string& source);

/// Every source has a thread of its own; one that vanishes is opened again when it comes back.
class LiveSenses {
public:
    /// Listens to all live sources of the tracker's site until `stop` is set. Both must outlive it.
    LiveSenses(SiteTracker& tracker, const std::atomic<bool>& stop);
    ~LiveSenses();
    LiveSenses(const LiveSenses&) = delete;
    LiveSenses& operator=(const LiveSenses&) = delete;

    /// Is there anything to listen to?
    bool listens() const { return !threads_.empty(); }
    /// Until `stop` is set, if there is anything to listen to.
    void wait();
    std::vector<SenseState> states() const;

private:
    void listen_to_line(const std::string& device, int robot, int receiver);
    void listen_to_port(const std::string& address);
    void listen_to_topic(const std::string& source);
    void listen_to_ros();
    template <class Open, class Take>
    void keep_open(const std::string& source, const std::string& at_first, const Open& open, const Take& take_bytes);
    void take(const std::string& source, SenseLines& lines, std::string_view text);
    void take(const std::string& source, const Readings& readings, const std::string& clocks);
    void note(const std::string& source, const std::string& message);
    void wait_a_moment() const;

    SiteTracker& tracker_;
    const std::atomic<bool>& stop_;
    mutable std::mutex mutex_;  // guards:
    std::map<std::string, SenseState> states_;
    std::vector<std::thread> threads_;
};

}  // namespace roomfix
