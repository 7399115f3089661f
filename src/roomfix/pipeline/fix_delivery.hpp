// Which fixes are due, and their way to whoever wants them.
#pragma once

#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "roomfix/pipeline/fix_sink.hpp"
#include "roomfix/pipeline/pace.hpp"
#include "roomfix/pipeline/stage_times.hpp"

namespace roomfix {

/// May be used from several threads; what becomes due is delivered in that order.
class FixDelivery {
public:
    /// How long it takes until fixes are due goes to `times`.
    explicit FixDelivery(StageTimes& times) : times_(times) {}

    void add_listener(std::function<void(const FixBatch&)> listener) { listeners_.push_back(std::move(listener)); }
    /// From now on fixes state how late they are.
    void measure_latency(const Pace& pace);
    bool measures_latency() const;
    /// Seconds of the clock from a time stamp to now.
    std::optional<double> latency(Nanoseconds time) const;

    /// Of all robots' fixes at a time those that are due wait to be delivered. That a robot is lost is said only once.
    void make_due(Nanoseconds time, std::vector<Fix> all, const std::function<bool(const Fix&)>& is_due, const LatencyParts& parts);
    /// Goes along with the next batch.
    void add_odometry(const OdometryObservation& report);
    /// Calls the listeners with all that waits, one batch at a time.
    void deliver();

    /// When a robot got its last fix; nothing if it never did.
    std::optional<Nanoseconds> last_given(const std::string& robot) const;
    /// Of the robot's newest fix, due or not.
    FixStatus last_status(const std::string& robot) const;

private:
    StageTimes& times_;
    std::vector<std::function<void(const FixBatch&)>> listeners_;
    mutable std::mutex pace_mutex_;  // guards:
    std::optional<Pace> pace_;
    std::mutex delivering_;     // held while listeners are called
    mutable std::mutex mutex_;  // guards:
    std::map<std::string, FixStatus> last_status_;
    std::map<std::string, Nanoseconds> last_given_;
    std::vector<FixBatch> due_;
    std::vector<OdometryObservation> odometry_;  // that no batch has taken along yet
};

}  // namespace roomfix
