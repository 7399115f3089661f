#include "roomfix/connect/odometry_source.hpp"

#include <fmt/format.h>

#include <array>
#include <optional>

#include "roomfix/base/csv.hpp"
#include "roomfix/base/number.hpp"
#include "roomfix/base/text_file.hpp"

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

Result<OdometryObservation> read_line(std::string_view line, const Columns& columns, const Site& site, int robot) {
    const auto fields = csv_fields(line);
    const auto field = [&](int column) { return csv_field(fields, column); };
    OdometryObservation pose;
    const auto time = parse_seconds(field(columns.time));
    if (!time) return Error{fmt::format("'{}' is no time in seconds", field(columns.time))};
    pose.time = *time;
    pose.robot = robot;
    if (columns.robot >= 0) {
        const auto index = site.robot(std::string(field(columns.robot)));
        if (!index) return Error{fmt::format("the site has no robot '{}'", field(columns.robot))};
        pose.robot = *index;
    }
    if (pose.robot < 0) return Error{"it names no robot: add a column 'robot'"};
    const std::array<std::pair<int, double*>, 3> values = {{{columns.x, &pose.pose.x}, {columns.y, &pose.pose.y}, {columns.yaw, &pose.pose.yaw}}};
    for (const auto& [column, value] : values) {
        const auto number = parse_number(field(column));
        if (!number) return Error{fmt::format("'{}' is no number", field(column))};
        *value = *number;
    }
    return pose;
}

}  // namespace

Result<OdometryBatch> parse_odometry(std::string_view text, const Site& site, int robot) {
    OdometryBatch batch;
    std::optional<Columns> columns;
    long number = 0;
    while (!text.empty()) {
        const std::size_t end = text.find('\n');
        const std::string_view line = text.substr(0, end);
        text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
        ++number;
        if (line.find_first_not_of(" \t\r") == std::string_view::npos) continue;
        if (!columns) {
            columns = read_header(line);
            if (!columns) return Error{"the first line must name the columns time,robot,x,y,yaw"};
            continue;
        }
        const auto pose = read_line(line, *columns, site, robot);
        if (pose) {
            batch.poses.push_back(*pose);
        } else if (batch.problems.size() < most_problems) {
            batch.problems.push_back(fmt::format("line {}: {}", number, pose.error().message));
        }
    }
    if (!columns) return Error{"it is empty: the first line must name the columns time,robot,x,y,yaw"};
    return batch;
}

Result<OdometryBatch> load_odometry(const std::string& file, const Site& site, int robot) {
    const auto text = read_text(file);
    if (!text) return Error{text.error().message + " (the odometry's 'source')"};
    auto batch = parse_odometry(*text, site, robot);
    if (!batch) return Error{file + ": " + batch.error().message};
    for (std::string& problem : batch->problems) problem.insert(0, file + ", ");
    return batch;
}

}  // namespace roomfix
