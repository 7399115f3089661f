#include "roomfix/connect/fix_store.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "roomfix/base/number.hpp"
#include "roomfix/connect/fix_json.hpp"

namespace roomfix {
namespace {

constexpr const char* columns = "time, robot, kind, status, x, y, yaw, xx, xy, xyaw, yy, yyaw, yawyaw, sources, reason";
constexpr std::size_t column_count = 15;

/// Where the covariance's six numbers stand in the matrix.
constexpr std::array<std::pair<int, int>, 6> entries = {{{0, 0}, {0, 1}, {0, 2}, {1, 1}, {1, 2}, {2, 2}}};

/// What a database needs before anything else; both kinds understand it.
std::vector<std::string> table_statements() {
    return {
        "CREATE TABLE IF NOT EXISTS roomfix_fixes (site TEXT NOT NULL, run BIGINT NOT NULL, number BIGINT NOT NULL, time BIGINT NOT NULL, robot TEXT NOT NULL, "
        "kind TEXT NOT NULL, status TEXT NOT NULL, x DOUBLE PRECISION, y DOUBLE PRECISION, yaw DOUBLE PRECISION, xx DOUBLE PRECISION, xy DOUBLE PRECISION, "
        "xyaw DOUBLE PRECISION, yy DOUBLE PRECISION, yyaw DOUBLE PRECISION, yawyaw DOUBLE PRECISION, sources TEXT NOT NULL, reason TEXT NOT NULL, "
        "PRIMARY KEY (site, run, number))",
        "CREATE TABLE IF NOT EXISTS roomfix_zone_events (site TEXT NOT NULL, run BIGINT NOT NULL, number BIGINT NOT NULL, time BIGINT NOT NULL, "
        "robot TEXT NOT NULL, zone TEXT NOT NULL, event TEXT NOT NULL, PRIMARY KEY (site, run, number))",
        "CREATE INDEX IF NOT EXISTS roomfix_zone_events_by_time ON roomfix_zone_events (site, time)",
        "CREATE INDEX IF NOT EXISTS roomfix_fixes_by_time ON roomfix_fixes (site, time)",
        "CREATE INDEX IF NOT EXISTS roomfix_fixes_by_robot ON roomfix_fixes (site, robot, time)",
    };
}

std::string sql_number(double value) { return std::isfinite(value) ? number_text(value) : "NULL"; }

std::string sources_text(const std::vector<std::string>& sources) {
    return nlohmann::json(sources).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

std::string values_of(const Fix& fix) {
    const bool found = fix.status != FixStatus::none;
    std::string text = fmt::format("{}, {}, '{}', '{}'", fix.time, sql_text(fix.robot), fix.unknown ? "unknown" : "robot", name_of(fix.status));
    const auto add = [&](bool known, double value) { text += ", " + (known ? sql_number(value) : std::string("NULL")); };
    add(found, fix.pose.x);
    add(found, fix.pose.y);
    add(found && fix.yaw_known, fix.pose.yaw);
    for (const auto& [row, column] : entries) add(found, fix.covariance(row, column));
    return text + fmt::format(", {}, {}", sql_text(sources_text(fix.sources)), sql_text(fix.reason));
}

std::string condition_of(const FixQuery& query, const std::string& site) {
    std::string text = "site = " + site;
    if (!query.robot.empty()) text += " AND robot = " + sql_text(query.robot);
    if (query.from) text += fmt::format(" AND time >= {}", *query.from);
    if (query.to) text += fmt::format(" AND time <= {}", *query.to);
    if (!query.zone.empty()) text += " AND zone = " + sql_text(query.zone);
    if (query.area) {
        text += fmt::format(" AND x >= {} AND x <= {} AND y >= {} AND y <= {}", number_text(query.area->x_from), number_text(query.area->x_to),
                            number_text(query.area->y_from), number_text(query.area->y_to));
    }
    return text;
}

double number_or(const std::optional<std::string>& text, double otherwise) {
    const auto number = text ? parse_number(*text) : std::nullopt;
    return number.value_or(otherwise);
}

/// Nothing if the row is none of ours.
std::optional<Fix> fix_of(const SqlRow& row) {
    if (row.size() != column_count || !row[0] || !row[1] || !row[2] || !row[3] || !row[13] || !row[14]) return std::nullopt;
    Fix fix;
    const auto time = parse_integer(*row[0]);
    if (!time) return std::nullopt;
    fix.time = *time;
    fix.robot = *row[1];
    fix.unknown = *row[2] == "unknown";
    fix.reason = *row[14];
    const bool found = row[4] && row[5] && (*row[3] == "ok" || *row[3] == "coasting");
    if (found) fix.status = *row[3] == "ok" ? FixStatus::ok : FixStatus::coasting;
    fix.yaw_known = row[6].has_value();
    fix.pose = {number_or(row[4], 0), number_or(row[5], 0), number_or(row[6], 0)};
    for (std::size_t i = 0; i < entries.size(); ++i) {
        const auto [r, c] = entries[i];
        fix.covariance(r, c) = fix.covariance(c, r) = number_or(row[7 + i], 0);
    }
    const auto sources = nlohmann::json::parse(*row[13], nullptr, false);
    for (const auto& source : sources.is_array() ? sources : nlohmann::json::array()) {
        if (source.is_string()) fix.sources.push_back(source.get<std::string>());
    }
    return fix;
}

}  // namespace

std::string sql_text(const std::string& text) {
    std::string quoted = "'";
    for (const char c : text) {
        if (c == '\0') break;
        quoted += c == '\'' ? "''" : std::string(1, c);
    }
    return quoted + "'";
}

FixStore::FixStore(std::unique_ptr<SqlDatabase> database, const std::string& site, std::int64_t run)
    : database_(std::move(database)), site_(sql_text(site)), run_(run) {}

bool is_database_server(const std::string& database) { return database.starts_with("postgresql://") || database.starts_with("postgres://"); }

Result<std::unique_ptr<FixStore>> FixStore::open(const std::string& database, const std::string& site, std::int64_t run) {
    const bool server = is_database_server(database);
    if (!server && database.find("://") != std::string::npos) {
        return Error{"outputs.history.database is an address of an unknown kind: give a file for SQLite, or postgresql://USER@HOST/DATABASE"};
    }
    if (!server) return std::unique_ptr<FixStore>(new FixStore(sqlite_database(database, table_statements()), site, run));
    auto connection = postgresql_database(database, table_statements());
    if (!connection) return connection.error();
    return std::unique_ptr<FixStore>(new FixStore(std::move(*connection), site, run));
}

Result<void> FixStore::add(std::span<const NumberedFix> fixes, std::span<const NumberedZoneEvent> events) {
    // Whoever does not know whether a transaction was the last that a dying server did may repeat it.
    constexpr const char* once = " ON CONFLICT (site, run, number) DO NOTHING";
    std::vector<std::string> statements;
    std::string values;
    for (const NumberedFix& numbered : fixes) {
        values += fmt::format("{} ({}, {}, {}, {})", values.empty() ? "" : ",", site_, run_, numbered.number, values_of(numbered.fix));
    }
    if (!fixes.empty()) statements.push_back(fmt::format("INSERT INTO roomfix_fixes (site, run, number, {}) VALUES{}{}", columns, values, once));
    values.clear();
    for (const auto& [number, event] : events) {
        values += fmt::format("{} ({}, {}, {}, {}, {}, {}, '{}')", values.empty() ? "" : ",", site_, run_, number, event.time, sql_text(event.robot),
                              sql_text(event.zone), event.entered ? "enter" : "leave");
    }
    if (!events.empty()) {
        statements.push_back(fmt::format("INSERT INTO roomfix_zone_events (site, run, number, time, robot, zone, event) VALUES{}{}", values, once));
    }
    return statements.empty() ? Result<void>() : database_->run(statements);
}

Result<std::vector<ZoneEvent>> FixStore::find_zone_events(const FixQuery& query) {
    const char* order = query.newest_first ? "DESC" : "ASC";
    const auto rows =
        database_->rows(fmt::format("SELECT time, robot, zone, event FROM roomfix_zone_events WHERE {} ORDER BY time {}, run {}, number {} LIMIT {}",
                                    condition_of(query, site_), order, order, order, query.limit));
    if (!rows) return rows.error();
    std::vector<ZoneEvent> events;
    for (const SqlRow& row : *rows) {
        const auto time = row.size() == 4 && row[0] && row[1] && row[2] && row[3] ? parse_integer(*row[0]) : std::nullopt;
        if (time) events.push_back({*time, *row[2], *row[1], *row[3] == "enter"});
    }
    return events;
}

Result<std::vector<Fix>> FixStore::find(const FixQuery& query) {
    const char* order = query.newest_first ? "DESC" : "ASC";
    const auto rows = database_->rows(fmt::format("SELECT {} FROM roomfix_fixes WHERE {} ORDER BY time {}, run {}, number {} LIMIT {}", columns,
                                                  condition_of(query, site_), order, order, order, query.limit));
    if (!rows) return rows.error();
    std::vector<Fix> fixes;
    for (const SqlRow& row : *rows) {
        if (auto fix = fix_of(row)) fixes.push_back(std::move(*fix));
    }
    return fixes;
}

Result<void> FixStore::remove_before(Nanoseconds time) {
    const auto removed_events = database_->run({fmt::format("DELETE FROM roomfix_zone_events WHERE site = {} AND time < {}", site_, time)});
    if (!removed_events) return removed_events;
    // An hour of fixes after the other: a server ends statements that take long, and after a pause there may be days of them.
    constexpr Nanoseconds slice = from_seconds(3600);
    constexpr int most_slices = 24;  // the rest comes next time
    for (int i = 0; i < most_slices; ++i) {
        const auto oldest = database_->rows("SELECT MIN(time) FROM roomfix_fixes WHERE site = " + site_);
        if (!oldest) return oldest.error();
        const auto begin = oldest->empty() || !oldest->front().front() ? std::nullopt : parse_integer(*oldest->front().front());
        if (!begin || *begin >= time) return {};
        const auto removed = database_->run({fmt::format("DELETE FROM roomfix_fixes WHERE site = {} AND time < {}", site_, std::min(time, *begin + slice))});
        if (!removed) return removed;
    }
    return {};
}

}  // namespace roomfix
