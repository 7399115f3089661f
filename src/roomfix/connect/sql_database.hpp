// A database that understands SQL: SQLite or PostgreSQL. What both say in the same way is said once, in fix_store.cpp.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "roomfix/base/result.hpp"

namespace roomfix {

using SqlRow = std::vector<std::optional<std::string>>;  // without a value: NULL

/// Connects when it is first needed, and again after a failure.
class SqlDatabase {
public:
    virtual ~SqlDatabase() = default;
    /// Statements in one transaction: all of them, or none.
    virtual Result<void> run(const std::vector<std::string>& statements) = 0;
    /// What a SELECT finds. Numbers as text that reads back as the same number.
    virtual Result<std::vector<SqlRow>> rows(const std::string& select) = 0;
};

/// `setup`: statements that are run after each connecting.
std::unique_ptr<SqlDatabase> sqlite_database(const std::string& file, std::vector<std::string> setup);
/// An error where the program was built without PostgreSQL. `address`: postgresql://...
Result<std::unique_ptr<SqlDatabase>> postgresql_database(const std::string& address, std::vector<std::string> setup);

/// A text as SQL, in quotes. What follows a zero byte is left out.
std::string sql_text(const std::string& text);

}  // namespace roomfix
