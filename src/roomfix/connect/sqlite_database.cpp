#include <fmt/format.h>
#include <sqlite3.h>

#include <chrono>
#include <filesystem>
#include <utility>

#include "roomfix/base/number.hpp"
#include "roomfix/connect/sql_database.hpp"

namespace roomfix {
namespace {

constexpr int patience = 3000;  // ms that it waits for another program's transaction
constexpr auto longest_select = std::chrono::seconds(10);

std::string cure_of(int problem) {
    switch (problem & 0xff) {
        case SQLITE_FULL:
            return "make room there, or choose another disk";
        case SQLITE_READONLY:
        case SQLITE_CANTOPEN:
        case SQLITE_PERM:
            return "check that the folder exists and may be written";
        case SQLITE_NOTADB:
        case SQLITE_CORRUPT:
            return "it is damaged or no database: move it away, a new one is made";
        case SQLITE_BUSY:
        case SQLITE_LOCKED:
            return "another program holds it";
        case SQLITE_INTERRUPT:
            return "the question takes too long: ask for less time, one robot or a smaller area";
        default:
            return "check the disk";
    }
}

std::optional<std::string> value_of(sqlite3_stmt* statement, int column) {
    switch (sqlite3_column_type(statement, column)) {
        case SQLITE_NULL:
            return std::nullopt;
        case SQLITE_FLOAT:
            return number_text(sqlite3_column_double(statement, column));
        default:
            return std::string(reinterpret_cast<const char*>(sqlite3_column_text(statement, column)),
                               static_cast<std::size_t>(sqlite3_column_bytes(statement, column)));
    }
}

class SqliteDatabase final : public SqlDatabase {
public:
    SqliteDatabase(std::string file, std::vector<std::string> setup) : file_(std::move(file)), setup_(std::move(setup)) {}
    ~SqliteDatabase() override { close(); }

    Result<void> run(const std::vector<std::string>& statements) override {
        if (auto connected = connect(); !connected) return connected;
        auto done = execute("BEGIN IMMEDIATE");
        for (const std::string& statement : statements) {
            if (done) done = execute(statement);
        }
        if (done) done = execute("COMMIT");
        if (!done && sqlite3_get_autocommit(database_) == 0) (void)execute("ROLLBACK");
        return done;
    }

    Result<std::vector<SqlRow>> rows(const std::string& select) override {
        if (auto connected = connect(); !connected) return connected.error();
        sqlite3_stmt* statement = nullptr;
        if (sqlite3_prepare_v2(database_, select.c_str(), -1, &statement, nullptr) != SQLITE_OK) return failure();
        select_end_ = std::chrono::steady_clock::now() + longest_select;
        std::vector<SqlRow> rows;
        int step = sqlite3_step(statement);
        for (; step == SQLITE_ROW; step = sqlite3_step(statement)) {
            SqlRow& row = rows.emplace_back();
            for (int i = 0; i < sqlite3_column_count(statement); ++i) row.push_back(value_of(statement, i));
        }
        select_end_.reset();
        const Error error = failure();
        sqlite3_finalize(statement);
        if (step != SQLITE_DONE) return error;
        return rows;
    }

private:
    /// A file that was deleted while it is open would swallow everything.
    Result<void> connect() {
        std::error_code ignored;
        if (database_ != nullptr && !std::filesystem::exists(file_, ignored)) close();
        if (database_ != nullptr) return {};
        const int flags = SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_NOMUTEX;
        Result<void> opened;
        if (sqlite3_open_v2(file_.c_str(), &database_, flags, nullptr) != SQLITE_OK) opened = failure();
        if (database_ != nullptr) {
            sqlite3_extended_result_codes(database_, 1);
            sqlite3_busy_timeout(database_, patience);
            sqlite3_progress_handler(database_, 10000, &too_long, this);
        }
        if (opened) opened = execute("PRAGMA journal_mode = WAL");
        if (opened) opened = execute("PRAGMA synchronous = NORMAL");
        for (const std::string& statement : setup_) {
            if (opened) opened = execute(statement);
        }
        if (!opened) close();
        return opened;
    }

    static int too_long(void* self) {
        const auto& end = static_cast<SqliteDatabase*>(self)->select_end_;
        return end && std::chrono::steady_clock::now() > *end ? 1 : 0;
    }

    Result<void> execute(const std::string& statement) {
        if (sqlite3_exec(database_, statement.c_str(), nullptr, nullptr, nullptr) == SQLITE_OK) return {};
        return failure();
    }

    Error failure() const {
        const int problem = database_ == nullptr ? SQLITE_NOMEM : sqlite3_errcode(database_);
        return Error{fmt::format("history {}: {}: {}", file_, sqlite3_errstr(problem), cure_of(problem))};
    }

    void close() {
        sqlite3_close(database_);
        database_ = nullptr;
    }

    std::string file_;
    std::vector<std::string> setup_;
    sqlite3* database_ = nullptr;
    std::optional<std::chrono::steady_clock::time_point> select_end_;
};

}  // namespace

std::unique_ptr<SqlDatabase> sqlite_database(const std::string& file, std::vector<std::string> setup) {
    return std::make_unique<SqliteDatabase>(file, std::move(setup));
}

}  // namespace roomfix
