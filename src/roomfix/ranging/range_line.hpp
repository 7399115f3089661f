// One line of text from a listener or a file, as the reading it states. Locale-free; never throws.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "roomfix/base/result.hpp"
#include "roomfix/base/time.hpp"

namespace roomfix {

/// What a line says, not yet compared with any site.
struct RangeLine {
    std::optional<Nanoseconds> time;
    std::optional<Nanoseconds> listener_clock;  // runs from the listener's start
    std::string robot;                          // empty: not said
    std::string receiver;                       // of the robot's; empty: not said
    std::string beacon;                         // id or address; of a difference: a
    std::string alias;                          // another name of the beacon (Cricket: its space)
    std::string far_beacon;                     // of a difference: b; empty for a range
    double value = 0;                           // m: range, or difference
    std::optional<double> flight_time;          // s, sound after radio; to be preferred to `value`
    std::optional<double> sigma;                // m
};

/// A line of an MIT Cricket v2 listener: NAME=VALUE pairs after commas, in any order: VR version, ID beacon (hexadecimal bytes with
/// colons, not always two digits each), SP space name, DB distance in cm, DR flight time in us, TM radio time, TS listener clock in
/// ms. Needs ID or SP, and DR or DB. A key given twice (two lines run into each other), unreadable numbers, and DR and DB that
/// contradict each other are errors. `temperature` (degC) turns DR into metres.
/// Source: Cricket v2 User Manual, MIT 2004.
Result<RangeLine> parse_cricket_line(std::string_view line, double temperature);

/// {"time": s, "robot": "r1", "beacon": "n1", "range": m, "sigma": m}, or with "beacons": ["a", "b"] and "difference": m instead of
/// beacon and range. time, robot, "receiver" and sigma may be missing; other keys are ignored.
Result<RangeLine> parse_json_line(std::string_view line);

/// A CSV file's first line: `time,robot,beacon,range[,sigma][,receiver]` or `time,robot,beacon_a,beacon_b,difference[,sigma][,receiver]`, in any
/// order.
struct RangeColumns {
    int time = -1, robot = -1, beacon = -1, range = -1, beacon_a = -1, beacon_b = -1, difference = -1, sigma = -1, receiver = -1;
    int count = 0;
};
Result<RangeColumns> parse_range_header(std::string_view line);
Result<RangeLine> parse_csv_line(std::string_view line, const RangeColumns& columns);

/// The eight bytes of a Cricket address in one spelling: lower case, two digits each, colons between. Nothing if it is none.
std::optional<std::string> normal_address(std::string_view text);

}  // namespace roomfix
