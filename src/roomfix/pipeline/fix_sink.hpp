// Where fixes go: files, the page, whatever else.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "roomfix/base/result.hpp"
#include "roomfix/connect/zone_event.hpp"
#include "roomfix/observation/fix.hpp"
#include "roomfix/observation/odometry_observation.hpp"

namespace roomfix {

/// The fixes of one moment.
struct FixBatch {
    Nanoseconds time = 0;
    std::vector<Fix> given;                                 // those that are due: of robots that this moment says something about, and of lost ones
    std::vector<Fix> all;                                   // of every robot that anything was said of, at that time
    std::vector<OdometryObservation> odometry;              // what robots' wheels reported since the last batch, as it came
    std::vector<ZoneEvent> zone_events;                     // what the given fixes change
    std::map<std::string, std::vector<std::string>> zones;  // that robots are in, each in the order of the site file; robots in none are left out

    /// The zones that a robot is in.
    std::vector<std::string> zones_of(const std::string& robot) const {
        const auto found = zones.find(robot);
        return found == zones.end() ? std::vector<std::string>() : found->second;
    }
};

/// How a sink fares, for the page and the final report.
struct SinkState {
    std::string name;
    std::string status = "ok";  // ok, failed
    std::string message;        // what is wrong, and what to do
    long lost = 0;              // of what it should have passed on
};

/// A sink works in a thread of its own (`SinkQueue`): it may be slow, stand still or fail without anything else noticing.
class FixSink {
public:
    virtual ~FixSink() = default;
    /// For messages.
    virtual std::string name() const { return "a sink"; }
    /// One batch after the other, in the order in which they came. An error says in words what was lost and what to do; it is told once, and the
    /// next batch is tried again.
    virtual Result<void> give(const FixBatch& batch) = 0;
    /// After the last batch.
    virtual Result<void> finish() { return {}; }
    /// Called from any thread; name() is put in by whoever asks.
    virtual SinkState state() const { return {}; }
};

/// What happens where a sink cannot keep up.
enum class Overflow {
    wait,         // whoever gives fixes waits: of a recording nothing is lost
    drop_oldest,  // the oldest batches that wait are thrown away, and the sink's end says how many
    newest_only,  // of what is only looked at: a batch that was not taken yet is replaced
};

}  // namespace roomfix
