// Fixes in a database, to be found again by robot, time and area.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "roomfix/base/result.hpp"
#include "roomfix/connect/sql_database.hpp"
#include "roomfix/connect/zone_event.hpp"
#include "roomfix/observation/fix.hpp"

namespace roomfix {

/// Is it the address of a server, and not a file?
bool is_database_server(const std::string& database);

/// A fix and its number within a run of the program: given twice, it is stored once.
struct NumberedFix {
    std::int64_t number = 0;
    Fix fix;
};

/// Likewise; its numbers are its own.
struct NumberedZoneEvent {
    std::int64_t number = 0;
    ZoneEvent event;
};

/// A rectangle of the map, m, its borders included.
struct Area {
    double x_from = 0, y_from = 0, x_to = 0, y_to = 0;
};

struct FixQuery {
    std::string robot;                    // or the name of a thing that is no robot; empty: all
    std::string zone;                     // of events only; empty: all
    std::optional<Nanoseconds> from, to;  // both included
    std::optional<Area> area;             // of fixes only; those without a place are in none
    int limit = 10000;                    // fixes at most
    bool newest_first = true;             // also: which ones are left out beyond the limit
};

/// The fixes of one site in a database that several sites may share. Used by one thread at a time. Every call may fail, since the database is gone, and the
/// next one succeed.
class FixStore {
public:
    /// `database`: an SQLite file, or postgresql://...; it is opened by the first call that needs it. `run`: a number of this run of the program.
    /// An error if the program cannot use such a database at all.
    static Result<std::unique_ptr<FixStore>> open(const std::string& database, const std::string& site, std::int64_t run = 0);

    /// All of them, or none.
    Result<void> add(std::span<const NumberedFix> fixes, std::span<const NumberedZoneEvent> events = {});
    Result<std::vector<Fix>> find(const FixQuery& query);
    Result<std::vector<ZoneEvent>> find_zone_events(const FixQuery& query);
    Result<void> remove_before(Nanoseconds time);

private:
    FixStore(std::unique_ptr<SqlDatabase> database, const std::string& site, std::int64_t run);

    std::unique_ptr<SqlDatabase> database_;
    std::string site_;  // as SQL
    std::int64_t run_;
};

}  // namespace roomfix
