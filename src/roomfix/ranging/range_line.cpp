#include "roomfix/ranging/range_line.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "roomfix/base/csv.hpp"
#include "roomfix/base/number.hpp"
#include "roomfix/ranging/flight_time.hpp"

namespace roomfix {
namespace {

/// At most 60 characters of a text, fit for a message.
std::string shown(std::string_view text) {
    std::string out;
    for (const char c : text.substr(0, 60)) out += c >= ' ' && c < 127 ? c : '?';
    return out + (text.size() > 60 ? "..." : "");
}

/// A flight time (s) and the distance that the listener made of it (m) must agree: it computes with a fixed speed of sound and
/// whole centimetres.
bool contradict(double flight_time, double distance) {
    const double range = range_from_delay(flight_time, 20);
    return std::abs(range - distance) > 0.02 + 0.08 * distance;
}

}  // namespace

std::optional<std::string> normal_address(std::string_view text) {
    std::string address;
    int bytes = 0;
    for (std::size_t begin = 0; begin <= text.size(); ++bytes) {
        const auto colon = std::min(text.find(':', begin), text.size());
        const std::string_view byte = text.substr(begin, colon - begin);
        if (byte.empty() || byte.size() > 2 || byte.find_first_not_of("0123456789abcdefABCDEF") != std::string_view::npos) return std::nullopt;
        if (bytes > 0) address += ':';
        if (byte.size() == 1) address += '0';
        for (const char c : byte) address += static_cast<char>(c >= 'A' && c <= 'F' ? c - 'A' + 'a' : c);
        begin = colon + 1;
    }
    if (bytes != 8) return std::nullopt;
    return address;
}

Result<RangeLine> parse_cricket_line(std::string_view line, double temperature) {
    const auto wrong = [&](const std::string& why) { return Error{fmt::format("Cricket line '{}': {}", shown(line), why)}; };
    RangeLine reading;
    std::optional<double> distance;
    std::vector<std::string_view> seen;
    for (const std::string_view field : csv_fields(line)) {
        if (field.empty()) continue;
        const auto equals = field.find('=');
        if (equals == std::string_view::npos) return wrong(fmt::format("'{}' has no '='", shown(field)));
        const std::string_view key = field.substr(0, equals);
        const std::string_view value = field.substr(equals + 1);
        if (std::find(seen.begin(), seen.end(), key) != seen.end())
            return wrong(fmt::format("{} stands there twice: two lines ran into each other", shown(key)));
        seen.push_back(key);
        if (key == "ID") {
            const auto address = normal_address(value);
            if (!address) return wrong("ID is not eight bytes");
            reading.beacon = *address;
        } else if (key == "SP") {
            const auto printable = [](char c) { return c > ' ' && c < 127 && c != '='; };
            if (value.empty() || !std::all_of(value.begin(), value.end(), printable)) return wrong("SP is not a name");
            reading.alias = value;
        } else if (key == "DB" || key == "DR" || key == "TS" || key == "TM") {
            const auto number = parse_number(value);
            if (!number || *number < 0 || *number > 1e12) return wrong(fmt::format("{} is not a number", key));
            if (key == "DB") distance = *number * 0.01;
            if (key == "DR") reading.flight_time = *number * 1e-6;
            if (key == "TS") reading.listener_clock = from_seconds(*number * 1e-3);
        }
    }
    if (reading.beacon.empty() && reading.alias.empty()) return wrong("no beacon: ID and SP are missing");
    if (!distance && !reading.flight_time) return wrong("no distance: DR and DB are missing");
    if (distance && reading.flight_time && contradict(*reading.flight_time, *distance)) return wrong("DR and DB contradict each other");
    reading.value = reading.flight_time ? range_from_delay(*reading.flight_time, temperature) : *distance;
    return reading;
}

Result<RangeLine> parse_json_line(std::string_view line) {
    const auto wrong = [&](const std::string& why) { return Error{fmt::format("range line '{}': {}", shown(line), why)}; };
    const auto json = nlohmann::json::parse(line, nullptr, false);
    if (json.is_discarded() || !json.is_object()) return wrong("not a JSON object");
    RangeLine reading;
    const auto text = [&](const char* key) { return json.contains(key) && json[key].is_string() ? json[key].get<std::string>() : std::string(); };
    const auto number = [&](const char* key) -> std::optional<double> {
        if (!json.contains(key) || !json[key].is_number()) return std::nullopt;
        return json[key].get<double>();
    };
    if (const auto time = number("time")) {
        if (!(std::abs(*time) < 9e9)) return wrong("time is no time in seconds");
        reading.time = from_seconds(*time);
    }
    reading.robot = text("robot");
    reading.receiver = text("receiver");
    reading.beacon = text("beacon");
    reading.sigma = number("sigma");
    auto value = number("range");
    if (json.contains("beacons")) {
        const auto& pair = json["beacons"];
        if (!pair.is_array() || pair.size() != 2 || !pair[0].is_string() || !pair[1].is_string()) return wrong("beacons must be two names");
        reading.beacon = pair[0].get<std::string>();
        reading.far_beacon = pair[1].get<std::string>();
        if (reading.far_beacon.empty()) return wrong("beacons must be two names");
        value = number("difference");
    }
    if (reading.beacon.empty()) return wrong("it needs \"beacon\" (or \"beacons\")");
    if (!value) return wrong(reading.far_beacon.empty() ? "it needs \"range\", a number of metres" : "it needs \"difference\", a number of metres");
    reading.value = *value;
    return reading;
}

Result<RangeColumns> parse_range_header(std::string_view line) {
    RangeColumns columns;
    const auto fields = csv_fields(line);
    columns.count = static_cast<int>(fields.size());
    for (int i = 0; i < columns.count; ++i) {
        const std::string_view name = fields[static_cast<std::size_t>(i)];
        int* column = name == "time"         ? &columns.time
                      : name == "robot"      ? &columns.robot
                      : name == "beacon"     ? &columns.beacon
                      : name == "range"      ? &columns.range
                      : name == "beacon_a"   ? &columns.beacon_a
                      : name == "beacon_b"   ? &columns.beacon_b
                      : name == "difference" ? &columns.difference
                      : name == "sigma"      ? &columns.sigma
                      : name == "receiver"   ? &columns.receiver
                                             : nullptr;
        if (!column) return Error{fmt::format("column '{}' is not known: write time,robot,beacon,range[,sigma][,receiver]", shown(name))};
        if (*column >= 0) return Error{fmt::format("column '{}' stands there twice", shown(name))};
        *column = i;
    }
    const bool ranges = columns.beacon >= 0 && columns.range >= 0;
    const bool differences = columns.beacon_a >= 0 && columns.beacon_b >= 0 && columns.difference >= 0;
    if (columns.time < 0 || ranges == differences) {
        return Error{fmt::format("the header '{}' is not time,robot,beacon,range[,sigma] or time,robot,beacon_a,beacon_b,difference[,sigma]", shown(line))};
    }
    return columns;
}

Result<RangeLine> parse_csv_line(std::string_view line, const RangeColumns& columns) {
    const auto wrong = [&](const std::string& why) { return Error{fmt::format("range line '{}': {}", shown(line), why)}; };
    const auto fields = csv_fields(line);
    if (static_cast<int>(fields.size()) != columns.count) return wrong(fmt::format("it has {} fields, the header has {}", fields.size(), columns.count));
    const auto field = [&](int column) { return column >= 0 ? fields[static_cast<std::size_t>(column)] : std::string_view(); };
    RangeLine reading;
    reading.time = parse_seconds(field(columns.time));
    if (!reading.time) return wrong("time is not a number of seconds");
    reading.robot = field(columns.robot);
    reading.receiver = field(columns.receiver);
    const bool difference = columns.difference >= 0;
    reading.beacon = field(difference ? columns.beacon_a : columns.beacon);
    reading.far_beacon = field(columns.beacon_b);
    if (reading.beacon.empty() || (difference && reading.far_beacon.empty())) return wrong("the beacon is missing");
    const auto value = parse_number(field(difference ? columns.difference : columns.range));
    if (!value) return wrong(difference ? "difference is not a number" : "range is not a number");
    reading.value = *value;
    if (!field(columns.sigma).empty()) {
        reading.sigma = parse_number(field(columns.sigma));
        if (!reading.sigma) return wrong("sigma is not a number");
    }
    return reading;
}

}  // namespace roomfix
