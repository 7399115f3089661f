#include "roomfix/ranging/range_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "roomfix/base/number.hpp"
#include "roomfix/ranging/flight_time.hpp"

namespace roomfix {

void RangeBatch::clear() {
    ranges.clear();
    differences.clear();
    problems.clear();
}

RangeReader::RangeReader(const Site& site, int robot, int receiver, const RangeReaderSettings& settings)
    : robots_(site.robots),
      beacons_(site.beacons),
      temperature_(site.temperature),
      robot_(robot),
      receiver_(receiver),
      settings_(settings),
      last_(site.beacons.size()) {
    for (SiteBeacon& beacon : beacons_) beacon.address = normal_address(beacon.address).value_or(beacon.address);
}

void RangeReader::feed(std::string_view bytes, std::optional<Nanoseconds> arrival, RangeBatch& batch) {
    while (!bytes.empty()) {
        const auto end = std::min(bytes.find('\n'), bytes.size());
        const std::string_view piece = bytes.substr(0, end);
        if (partial_.size() + piece.size() > settings_.longest_line) {
            oversized_ = true;
            partial_.clear();
        }
        if (!oversized_) partial_ += piece;
        if (end == bytes.size()) return;
        bytes.remove_prefix(end + 1);
        finish(arrival, batch);
    }
}

void RangeReader::finish(std::optional<Nanoseconds> arrival, RangeBatch& batch) {
    if (oversized_) {
        ++lines_;
        ++bad_lines_;
        batch.problems.push_back(
            fmt::format("a line of more than {} characters was dropped: is this the right serial line and speed?", settings_.longest_line));
    } else {
        take_line(partial_, arrival, batch);
    }
    oversized_ = false;
    partial_.clear();
}

void RangeReader::take_line(std::string_view line, std::optional<Nanoseconds> arrival, RangeBatch& batch) {
    while (!line.empty() && (line.back() == '\r' || line.back() == ' ' || line.back() == '\t')) line.remove_suffix(1);
    if (line.empty() || line.front() == '#') return;
    ++lines_;
    const auto reject = [&](const Error& error) {
        ++bad_lines_;
        batch.problems.push_back(error.message);
    };
    if (line.find("time") == 0 || (lines_ == 1 && line.find('=') == std::string_view::npos && line.front() != '{')) {
        const auto header = parse_range_header(line);
        if (!header) return reject(header.error());
        columns_ = *header;
        return;
    }
    const auto reading = parse(line);
    if (!reading) return reject(reading.error());
    if (const auto added = add(*reading, arrival, batch); !added) reject(added.error());
}

Result<RangeLine> RangeReader::parse(std::string_view line) {
    if (line.front() == '{') return parse_json_line(line);
    if (columns_) return parse_csv_line(line, *columns_);
    return parse_cricket_line(line, temperature_);
}

std::optional<int> RangeReader::robot_index(const std::string& name) const {
    if (name.empty()) return robot_ >= 0 ? std::optional(robot_) : std::nullopt;
    for (std::size_t i = 0; i < robots_.size(); ++i) {
        if (robots_[i].id == name) return static_cast<int>(i);
    }
    return std::nullopt;
}

std::optional<int> RangeReader::beacon_index(const std::string& name) const {
    for (std::size_t i = 0; i < beacons_.size() && !name.empty(); ++i) {
        if (beacons_[i].id == name || beacons_[i].address == name) return static_cast<int>(i);
    }
    return std::nullopt;
}

Result<void> RangeReader::add(const RangeLine& reading, std::optional<Nanoseconds> arrival, RangeBatch& batch) {
    const auto robot = robot_index(reading.robot);
    if (!robot) {
        return reading.robot.empty() ? Error{"a range without a robot: give the line a robot, or the robot a 'receiver' with this source"}
                                     : Error{fmt::format("a range of robot '{}', which the site does not have", reading.robot)};
    }
    auto beacon = beacon_index(reading.beacon);
    if (!beacon) beacon = beacon_index(reading.alias);
    const auto far = beacon_index(reading.far_beacon);
    const bool difference = !reading.far_beacon.empty();
    if (!beacon || (difference && !far)) {
        const std::string& name = beacon ? reading.far_beacon : reading.beacon.empty() ? reading.alias : reading.beacon;
        return Error{fmt::format("unknown beacon '{}': add it under 'beacons' with its position (and its 'address')", name)};
    }
    if (difference && *far == *beacon) return Error{fmt::format("a range difference between beacon '{}' and itself", reading.beacon)};
    const double largest = settings_.largest_range;
    if (!std::isfinite(reading.value) || std::abs(reading.value) > largest || (!difference && reading.value <= 0)) {
        return Error{fmt::format("beacon {}: a range of {} m cannot be: it must lie between 0 and {} m", beacons_[static_cast<std::size_t>(*beacon)].id,
                                 number_text(reading.value), number_text(largest))};
    }
    if (reading.sigma && !(*reading.sigma > 0 && *reading.sigma <= largest)) {
        return Error{fmt::format("a range with sigma {}: it must be positive, in metres", number_text(*reading.sigma))};
    }
    const auto time = reading.time ? reading.time : arrival ? arrival : reading.listener_clock;
    if (!time) return Error{"a range without a time: add 'time' in seconds"};
    auto& last = last_[static_cast<std::size_t>(*beacon)];
    const bool backwards = last && to_seconds(*last - *time) > settings_.backwards;
    last = *time;  // a clock that was set back is believed from the next line on
    if (backwards)
        return Error{fmt::format("beacon {}: the clock ran backwards to {} s: this range is not used", beacons_[static_cast<std::size_t>(*beacon)].id,
                                 seconds_text(*time))};

    const SiteRobot& owner = robots_[static_cast<std::size_t>(*robot)];
    const auto receiver = reading.receiver.empty() && *robot == robot_ ? std::optional(receiver_) : owner.receiver_index(reading.receiver);
    if (!receiver && !reading.receiver.empty()) {
        return Error{fmt::format("robot {} has no receiver '{}': add it under robots.{}.receivers with its position", owner.id, reading.receiver, owner.id)};
    }
    const auto number = static_cast<std::size_t>(receiver.value_or(0));
    double sigma = reading.sigma.value_or(number < owner.receivers.size() ? owner.receivers[number].sigma : Receiver().sigma);
    if (reading.flight_time) sigma = std::hypot(sigma, temperature_sigma(reading.value, temperature_, settings_.temperature_sigma));
    if (difference) {
        batch.differences.push_back({*time, *robot, {*beacon, *far}, reading.value, sigma, receiver.value_or(0)});
    } else {
        batch.ranges.push_back({*time, *robot, *beacon, reading.value, sigma, receiver.value_or(0)});
    }
    return {};
}

}  // namespace roomfix
