#include "roomfix/pipeline/fix_delivery.hpp"

#include <algorithm>
#include <utility>

#include "roomfix/base/steady_now.hpp"

namespace roomfix {
namespace {

/// Cameras that looked together, each by its own name, none twice.
std::vector<std::string> single_sources(const std::vector<std::string>& sources) {
    std::vector<std::string> single;
    for (const std::string& source : sources) {
        for (std::size_t begin = 0; begin <= source.size();) {
            const std::size_t end = std::min(source.find('+', begin), source.size());
            const std::string name = source.substr(begin, end - begin);
            if (std::find(single.begin(), single.end(), name) == single.end()) single.push_back(name);
            begin = end + 1;
        }
    }
    return single;
}

}  // namespace

void FixDelivery::measure_latency(const Pace& pace) {
    const std::lock_guard lock(pace_mutex_);
    pace_ = pace;
}

bool FixDelivery::measures_latency() const {
    const std::lock_guard lock(pace_mutex_);
    return pace_.has_value();
}

std::optional<double> FixDelivery::latency(Nanoseconds time) const {
    const std::lock_guard lock(pace_mutex_);
    if (!pace_) return std::nullopt;
    return steady_now() - pace_->wall_of(time);
}

void FixDelivery::make_due(Nanoseconds time, std::vector<Fix> all, const std::function<bool(const Fix&)>& is_due, const LatencyParts& parts) {
    const std::lock_guard lock(mutex_);
    const double before = steady_now();
    FixBatch batch{time, {}, std::move(all), std::exchange(odometry_, {})};
    for (Fix& fix : batch.all) {
        const bool due = is_due(fix);
        fix.sources = single_sources(fix.sources);
        FixStatus& last = last_status_.try_emplace(fix.robot, FixStatus::none).first->second;
        const bool said = fix.status == FixStatus::none && last == FixStatus::none;
        last = fix.status;
        if (said || !due) continue;
        const auto [last_time, first] = last_given_.try_emplace(fix.robot, time);
        if (!first && fix.status != FixStatus::ok && last_time->second == time) continue;  // another source of the same moment has said it
        last_time->second = time;
        Fix& given = batch.given.emplace_back(fix);
        given.latency = latency(time);
        if (!given.latency) continue;
        times_.add(Stage::latency, *given.latency);
        if (parts.looking <= 0) continue;
        given.latency_parts = parts;
        given.latency_parts->tracking = *given.latency - parts.waiting - parts.looking - parts.fitting;
    }
    due_.push_back(std::move(batch));
    times_.add(Stage::publish, steady_now() - before);
}

void FixDelivery::add_odometry(const OdometryObservation& report) {
    constexpr std::size_t most = 1000;  // while nothing else comes, old ones are of no use to anybody
    const std::lock_guard lock(mutex_);
    if (odometry_.size() >= most) odometry_.erase(odometry_.begin(), odometry_.begin() + most / 2);
    odometry_.push_back(report);
}

void FixDelivery::deliver() {
    const std::lock_guard order(delivering_);
    std::vector<FixBatch> batches;
    {
        const std::lock_guard lock(mutex_);
        batches.swap(due_);
    }
    for (const FixBatch& batch : batches) {
        for (const auto& listener : listeners_) listener(batch);
    }
}

std::optional<Nanoseconds> FixDelivery::last_given(const std::string& robot) const {
    const std::lock_guard lock(mutex_);
    const auto last = last_given_.find(robot);
    if (last == last_given_.end()) return std::nullopt;
    return last->second;
}

FixStatus FixDelivery::last_status(const std::string& robot) const {
    const std::lock_guard lock(mutex_);
    const auto last = last_status_.find(robot);
    return last == last_status_.end() ? FixStatus::none : last->second;
}

}  // namespace roomfix
