#include "roomfix/pipeline/live_senses.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <set>

#include "roomfix/base/steady_now.hpp"
#include "roomfix/connect/range_source.hpp"
#include "roomfix/connect/udp_port.hpp"
#include "roomfix/pipeline/mqtt_sink.hpp"
#include "roomfix/pipeline/ros2_senses.hpp"

namespace roomfix {
namespace {

constexpr double wait_for_bytes = 0.2;            // s
constexpr std::size_t longest_message = 1 << 20;  // bytes
constexpr std::string_view topic_scheme = "mqtt:";

/// All sources of a site's senses, each once.
std::set<std::string> sources_of(const Site& site) {
    std::set<std::string> sources;
    for (const SiteRobot& robot : site.robots) {
        for (const Receiver& receiver : robot.receivers) sources.insert(receiver.source);
        if (robot.odometry) sources.insert(robot.odometry->source);
        if (robot.detector) sources.insert(robot.detector->source);
    }
    return sources;
}

/// What is wrong with readings, with the source that they came from.
void say_where(const std::string& source, Readings& readings) {
    for (std::vector<std::string>* problems : {&readings.ranges.problems, &readings.odometry.problems, &readings.sightings.problems}) {
        for (std::string& problem : *problems) problem = source + ": " + problem;
    }
}

}  // namespace

bool is_serial_line(const std::string& source) { return source.starts_with("/dev/"); }
bool is_udp_address(const std::string& source) { return source.starts_with("udp://"); }
bool is_mqtt_topic(const std::string& source) { return source.starts_with(topic_scheme); }
bool is_live_sense(const std::string& source) { return is_serial_line(source) || is_udp_address(source) || is_mqtt_topic(source) || is_ros_topic(source); }

LiveSenses::LiveSenses(SiteTracker& tracker, const std::atomic<bool>& stop) : tracker_(tracker), stop_(stop) {
    const std::vector<SiteRobot>& robots = tracker.site().robots;
    for (std::size_t r = 0; r < robots.size(); ++r) {
        for (std::size_t k = 0; k < robots[r].receivers.size(); ++k) {
            const std::string& source = robots[r].receivers[k].source;
            if (!is_serial_line(source)) continue;
            threads_.emplace_back([this, source, robot = static_cast<int>(r), receiver = static_cast<int>(k)] { listen_to_line(source, robot, receiver); });
        }
    }
    for (const std::string& source : sources_of(tracker.site())) {
        if (is_udp_address(source)) threads_.emplace_back([this, source] { listen_to_port(source); });
        if (is_mqtt_topic(source)) threads_.emplace_back([this, source] { listen_to_topic(source); });
    }
    const auto by_ros = [](const SiteRobot& robot) { return robot.odometry && is_ros_topic(robot.odometry->source); };
    if (std::any_of(robots.begin(), robots.end(), by_ros)) threads_.emplace_back([this] { listen_to_ros(); });
}

LiveSenses::~LiveSenses() { wait(); }

void LiveSenses::wait() {
    for (std::thread& thread : threads_) thread.join();
    threads_.clear();
}

std::vector<SenseState> LiveSenses::states() const {
    const std::lock_guard lock(mutex_);
    std::vector<SenseState> states;
    for (const auto& [source, state] : states_) states.push_back(state);
    return states;
}

void LiveSenses::note(const std::string& source, const std::string& message) {
    const std::lock_guard lock(mutex_);
    SenseState& state = states_[source];
    state.source = source;
    state.message = message;
}

void LiveSenses::wait_a_moment() const {
    for (int i = 0; i < 20 && !stop_; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(100));
}

void LiveSenses::take(const std::string& source, const Readings& readings, const std::string& clocks) {
    const auto& [ranges, odometry, sightings] = readings;
    if (!odometry.poses.empty() || !odometry.problems.empty()) tracker_.process(odometry);
    if (!sightings.sightings.empty() || !sightings.problems.empty()) tracker_.process(sightings);
    if (!ranges.ranges.empty() || !ranges.differences.empty() || !ranges.problems.empty()) tracker_.process(ranges);
    const std::lock_guard lock(mutex_);
    SenseState& state = states_[source];
    state.source = source;
    state.message = clocks;
    state.readings += static_cast<long>(ranges.ranges.size() + ranges.differences.size() + odometry.poses.size() + sightings.sightings.size());
}

void LiveSenses::take(const std::string& source, SenseLines& lines, std::string_view text) {
    Readings readings = lines.read(text, system_now(), steady_now());
    say_where(source, readings);
    std::string clocks;
    for (const std::string& clock : lines.clocks()) clocks += (clocks.empty() ? "" : "; ") + clock;
    take(source, readings, clocks);
}

/// Opens a source, again and again if it must be, and passes on what comes from it.
template <class Open, class Take>
void LiveSenses::keep_open(const std::string& source, const std::string& at_first, const Open& open, const Take& take_bytes) {
    std::string bytes;
    while (!stop_) {
        auto line = open(source);
        note(source, line ? at_first : line.error().message);
        if (!line) tracker_.add_problems({line.error().message});
        while (line && !stop_ && line->read(wait_for_bytes, bytes)) {
            if (!bytes.empty()) take_bytes(bytes);
            bytes.clear();
        }
        wait_a_moment();
    }
}

/// A listener of Cricket's kind.
void LiveSenses::listen_to_line(const std::string& device, int robot, int receiver) {
    RangeReader reader(tracker_.site(), robot, receiver);
    keep_open(device, "", SerialLine::open, [&](const std::string& bytes) {
        Readings readings;
        reader.feed(bytes, system_now(), readings.ranges);
        say_where(device, readings);
        take(device, readings, "");
    });
}

void LiveSenses::listen_to_port(const std::string& address) {
    SenseLines lines(tracker_.site(), address);
    keep_open(address, "nothing has come yet", UdpPort::open, [&](const std::string& text) { take(address, lines, text); });
}

/// The client calls from its own thread; this one waits and says how the connection is.
void LiveSenses::listen_to_topic(const std::string& source) {
    if (!tracker_.site().outputs.mqtt) {
        tracker_.add_problems({fmt::format("{}: readings by MQTT need outputs.mqtt with the broker", source)});
        return;
    }
    SenseLines lines(tracker_.site(), source);
    const auto connection = mqtt_connection(tracker_.site(), *tracker_.site().outputs.mqtt);
    const auto listener = [&](const std::string&, std::string_view payload) { take(source, lines, payload.substr(0, longest_message)); };
    auto client =
        connection ? MqttClient::start(*connection, {source.substr(topic_scheme.size())}, listener) : Result<std::unique_ptr<MqttClient>>(connection.error());
    if (!client) {
        tracker_.add_problems({client.error().message});
        return;
    }
    note(source, "nothing has come yet");
    std::string told;
    while (!stop_) {
        const std::string problem = (*client)->state().problem;
        if (problem != told) {
            told = problem;
            note(source, problem);
            if (!problem.empty()) tracker_.add_problems({source + ": " + problem});
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
}

/// All ROS 2 topics at once. Where the domain cannot be joined it is tried again; who publishes them may come and go.
void LiveSenses::listen_to_ros() {
    std::string problem;
    while (!stop_) {
        const auto senses = Ros2Senses::open(tracker_.site());
        if (!senses && senses.error().message != problem) {
            problem = senses.error().message;
            tracker_.add_problems({problem});
            for (const std::string& source : sources_of(tracker_.site())) {
                if (is_ros_topic(source)) note(source, problem);
            }
        }
        while (senses && !stop_) {
            for (const Ros2Senses::Heard& heard : (*senses)->read(wait_for_bytes)) take(heard.source, {{}, heard.reports, {}}, heard.told);
        }
        wait_a_moment();
    }
}

}  // namespace roomfix
