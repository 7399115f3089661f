#include "roomfix/connect/history_answer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "roomfix/base/number.hpp"
#include "roomfix/base/printable.hpp"
#include "roomfix/connect/fix_json.hpp"

namespace roomfix {
namespace {

constexpr int highest_limit = 100000;
constexpr std::size_t longest_value = 200;  // characters

/// A text of others as it may stand in an answer: printable, and not too long.
std::string shown(const std::string& text) { return printable(text.substr(0, 60)); }

/// A moment in seconds; also what comes out of a computer's arithmetic, such as 1.7e9.
std::optional<Nanoseconds> moment_of(const std::string& text) {
    if (const auto exact = parse_seconds(text)) return exact;
    const auto seconds = parse_number(text);
    if (!seconds || std::abs(*seconds) > 9e9) return std::nullopt;
    return from_seconds(*seconds);
}

Result<void> read_time(const std::string& name, const std::string& text, std::optional<Nanoseconds>& time) {
    time = moment_of(text);
    if (time) return {};
    return Error{fmt::format("'{}' is no time: {} is given in seconds since 1970, as in the fixes", shown(text), name)};
}

Result<void> read_area(const std::string& text, std::optional<Area>& area) {
    const auto numbers = parse_numbers(text);
    if (!numbers || numbers->size() != 4) return Error{fmt::format("'{}' is no area: write area=x1,y1,x2,y2, two corners in metres of the map", shown(text))};
    const auto [x_from, x_to] = std::minmax((*numbers)[0], (*numbers)[2]);
    const auto [y_from, y_to] = std::minmax((*numbers)[1], (*numbers)[3]);
    area = Area{x_from, y_from, x_to, y_to};
    return {};
}

Result<void> read_limit(const std::string& text, int& limit) {
    const auto number = parse_integer(text);
    if (!number || *number < 1 || *number > highest_limit) {
        return Error{fmt::format("'{}' is no limit: it must be a whole number from 1 to {}", shown(text), highest_limit)};
    }
    limit = static_cast<int>(*number);
    return {};
}

/// A name as site files allow it.
Result<void> read_name(const std::string& what, const std::string& text, std::string& id) {
    const auto fits = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-'; };
    if (text.empty() || !std::all_of(text.begin(), text.end(), fits)) {
        return Error{fmt::format("'{0}' is no {1}'s name: letters, digits, '_' and '-'; leave {1} out for all {1}s", shown(text), what)};
    }
    id = text;
    return {};
}

/// One of two words.
Result<void> read_choice(const std::string& name, const std::string& text, const char* no, const char* yes, bool& value) {
    if (text != no && text != yes) return Error{fmt::format("'{}' is not possible: {} is {} or {}", shown(text), name, no, yes)};
    value = text == yes;
    return {};
}

Result<void> read_parameter(const std::string& name, const std::string& value, HistoryRequest& request) {
    FixQuery& query = request.query;
    if (name == "from") return read_time(name, value, query.from);
    if (name == "to") return read_time(name, value, query.to);
    if (name == "area") return read_area(value, query.area);
    if (name == "limit") return read_limit(value, query.limit);
    if (name == "order") return read_choice(name, value, "oldest", "newest", query.newest_first);
    if (name == "format") return read_choice(name, value, "jsonl", "csv", request.csv);
    if (name == "zone") return read_name(name, value, query.zone);
    if (name != "robot") return Error{fmt::format("'{}' is not known: there are robot, from, to, area, limit, order and format", shown(name))};
    return read_name(name, value, query.robot);
}

/// A field of a CSV line, in quotes where it must be.
std::string csv_text(const std::string& text) {
    if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
    std::string quoted = "\"";
    for (const char c : text) quoted += c == '"' ? "\"\"" : std::string(1, c);
    return quoted + "\"";
}

}  // namespace

Result<HistoryRequest> parse_history_request(const WebParameters& parameters) {
    HistoryRequest request;
    for (const auto& [name, value] : parameters) {
        if (parameters.count(name) > 1) return Error{fmt::format("'{}' is given twice", shown(name))};
        if (value.size() > longest_value) return Error{fmt::format("'{}' is too long", shown(name))};
        if (const auto read = read_parameter(name, value, request); !read) return read.error();
    }
    const FixQuery& query = request.query;
    if (query.from && query.to && *query.from > *query.to) return Error{"from lies after to: exchange them"};
    return request;
}

std::string fixes_csv(const std::vector<Fix>& fixes) {
    std::string text = "time,robot,kind,status,x,y,yaw,xx,xy,xyaw,yy,yyaw,yawyaw,sources\n";
    for (const Fix& fix : fixes) {
        const bool found = fix.status != FixStatus::none;
        const auto number = [&](bool known, double value) { return known ? number_text(value) : std::string(); };
        text += fmt::format("{},{},{},{},{},{},{}", seconds_text(fix.time), csv_text(fix.robot), fix.unknown ? "unknown" : "robot", name_of(fix.status),
                            number(found, fix.pose.x), number(found, fix.pose.y), number(found && fix.yaw_known, fix.pose.yaw));
        const Eigen::Matrix3d& p = fix.covariance;
        for (const double value : {p(0, 0), p(0, 1), p(0, 2), p(1, 1), p(1, 2), p(2, 2)}) text += "," + number(found, value);
        text += "," + csv_text(fmt::format("{}", fmt::join(fix.sources, " "))) + "\n";
    }
    return text;
}

std::string zone_event_line(const ZoneEvent& event) {
    return fmt::format(R"({{"time": {}, "robot": {}, "zone": {}, "event": "{}"}})", seconds_text(event.time), nlohmann::json(event.robot).dump(),
                       nlohmann::json(event.zone).dump(), event.entered ? "enter" : "leave");
}

WebAnswer answer_zone_history(FixStore& store, const WebParameters& parameters) {
    for (const char* of_fixes : {"area", "format"}) {
        if (parameters.contains(of_fixes))
            return {400, "text/plain", fmt::format("events of zones have no {}: there are robot, zone, from, to, limit and order\n", of_fixes)};
    }
    const auto request = parse_history_request(parameters);
    if (!request) return {400, "text/plain", request.error().message + "\n"};
    const auto events = store.find_zone_events(request->query);
    if (!events) return {503, "text/plain", events.error().message + "\n"};
    std::string lines;
    for (const ZoneEvent& event : *events) lines += zone_event_line(event) + '\n';
    return {200, "application/x-ndjson", std::move(lines)};
}

WebAnswer answer_history(FixStore& store, const WebParameters& parameters) {
    const auto request = parse_history_request(parameters);
    if (!request) return {400, "text/plain", request.error().message + "\n"};
    if (!request->query.zone.empty())
        return {400, "text/plain", "fixes have no zone: /api/history/zones tells who entered and left; area=x1,y1,x2,y2 is a rectangle\n"};
    const auto fixes = store.find(request->query);
    if (!fixes) return {503, "text/plain", fixes.error().message + "\n"};
    if (request->csv) return {200, "text/csv", fixes_csv(*fixes)};
    std::string lines;
    for (const Fix& fix : *fixes) lines += fix_line(fix) + '\n';
    return {200, "application/x-ndjson", std::move(lines)};
}

}  // namespace roomfix
