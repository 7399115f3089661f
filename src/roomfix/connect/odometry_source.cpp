#include "roomfix/connect/odometry_source.hpp"

#include <fmt/format.h>

#include <array>
#include <nlohmann/json.hpp>
#include <optional>

#include "roomfix/base/csv.hpp"
#include "roomfix/base/number.hpp"
#include "roomfix/base/text_file.hpp"
#include "roomfix/connect/json_text.hpp"
#include "roomfix/connect/sensed_lines.hpp"

namespace roomfix {
namespace {

constexpr std::size_t most_problems = 20;

/// Where each value stands; -1: nowhere.
struct Columns {
    int time = -1, robot = -1, x = -1, y = -1, yaw = -1;
};

std::optional<Columns> read_header(std::string_view line) {
    const auto fields = csv_fields(line);
    const Columns columns{csv_column(fields, "time"), csv_column(fields, "robot"), csv_column(fields, "x"), csv_column(fields, "y"), csv_column(fields, "yaw")};
    if (columns.time < 0 || columns.x < 0 || columns.y < 0 || columns.yaw < 0) return std::nullopt;
    return columns;
}

/// What a line says, as text; no robot: it does not say.
struct OdometryText {
    std::string time, x, y, yaw;
    std::optional<std::string> robot;
};

OdometryText text_of_csv(std::string_view line, const Columns& columns) {
    const auto fields = csv_fields(line);
    const auto field = [&](int column) { return std::string(csv_field(fields, column)); };
    OdometryText text{field(columns.time), field(columns.x), field(columns.y), field(columns.yaw), std::nullopt};
    if (columns.robot >= 0) text.robot = field(columns.robot);
    return text;
}

Result<OdometryText> text_of_json(std::string_view line) {
    const auto json = nlohmann::json::parse(line, nullptr, false);
    if (!json.is_object()) return Error{"it is no JSON object"};
    OdometryText text{json_text(json, "time"), json_text(json, "x"), json_text(json, "y"), json_text(json, "yaw"), std::nullopt};
    if (json.contains("robot")) text.robot = json_text(json, "robot");
    return text;
}

Result<OdometryObservation> observation_of(const OdometryText& text, const Site& site, int robot) {
    OdometryObservation pose;
    const auto time = parse_seconds(text.time);
    if (!time) return Error{fmt::format("'{}' is no time in seconds", text.time)};
    pose.time = *time;
    pose.robot = robot;
    if (text.robot) {
        const auto index = site.robot(*text.robot);
        if (!index) return Error{fmt::format("the site has no robot '{}'", *text.robot)};
        pose.robot = *index;
    }
    if (pose.robot < 0) return Error{"it names no robot: add a column 'robot'"};
    const std::array<std::pair<const std::string*, double*>, 3> values = {{{&text.x, &pose.pose.x}, {&text.y, &pose.pose.y}, {&text.yaw, &pose.pose.yaw}}};
    for (const auto& [said, value] : values) {
        const auto number = parse_number(*said);
        if (!number) return Error{fmt::format("'{}' is no number", *said)};
        *value = *number;
    }
    return pose;
}

}  // namespace

Result<OdometryBatch> parse_odometry(std::string_view text, const Site& site, int robot) {
    OdometryBatch batch;
    std::optional<Columns> columns;
    long number = 0;
    bool read = false;
    while (!text.empty()) {
        const std::size_t end = text.find('\n');
        const std::string_view line = text.substr(0, end);
        text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
        ++number;
        const std::size_t first = line.find_first_not_of(" \t\r");
        if (first == std::string_view::npos) continue;
        const bool json = line[first] == '{';
        if (!json && !columns) {
            columns = read_header(line);
            if (!columns) return Error{"the first line must name the columns time,robot,x,y,yaw"};
            read = true;
            continue;
        }
        read = true;
        const auto said = json ? text_of_json(line) : Result<OdometryText>(text_of_csv(line, *columns));
        const auto pose = said ? observation_of(*said, site, robot) : Result<OdometryObservation>(said.error());
        if (pose) {
            batch.poses.push_back(*pose);
        } else if (batch.problems.size() < most_problems) {
            batch.problems.push_back(fmt::format("line {}: {}", number, pose.error().message));
        }
    }
    if (!read) return Error{"it is empty: the first line must name the columns time,robot,x,y,yaw"};
    return batch;
}

Result<OdometryBatch> load_odometry(const std::string& file, const Site& site, int robot) {
    const auto sensed = read_sensed(file);
    if (!sensed) return Error{sensed.error().message + " (the odometry's 'source')"};
    auto batch = parse_odometry(sensed->text, site, robot);
    if (!batch) return Error{file + ": " + batch.error().message};
    if (!sensed->note.empty()) batch->problems.push_back(sensed->note);
    for (std::string& problem : batch->problems) problem.insert(0, file + ", ");
    return batch;
}

}  // namespace roomfix
