#include "roomfix/connect/time_errors.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "roomfix/base/csv.hpp"
#include "roomfix/base/number.hpp"
#include "roomfix/base/printable.hpp"
#include "roomfix/base/text_file.hpp"
#include "roomfix/base/text_lines.hpp"

namespace roomfix {
namespace {

constexpr double largest_sigma = 1e3;  // s
constexpr std::string_view heading = time_error_columns.substr(0, time_error_columns.size() - 1);
constexpr int most_ways = 1'000'000'000;

std::optional<TimeErrorChange> change_of(std::string_view line) {
    const auto fields = csv_fields(line);
    if (fields.size() != 3) return std::nullopt;
    const auto time = parse_integer(fields[0]);
    const auto sigma = parse_number(fields[1]);
    const auto way = parse_integer(fields[2]);
    if (!time || !sigma || !way || *sigma < 0 || *sigma > largest_sigma || *way < 0 || *way > most_ways) return std::nullopt;
    return TimeErrorChange{*time, {*sigma, static_cast<int>(*way)}};
}

}  // namespace

std::string time_error_line(const TimeErrorChange& change) { return fmt::format("{},{},{}\n", change.time, change.error.sigma, change.error.way); }

Result<std::vector<TimeErrorChange>> parse_time_errors(std::string_view text) {
    std::vector<TimeErrorChange> changes;
    std::string problem;
    each_line(text, [&](std::string_view line, long number) {
        if (!problem.empty() || (number == 1 && line == heading)) return;
        const auto change = change_of(line);
        const bool in_order = change && (changes.empty() || changes.back().time <= change->time);
        if (in_order) {
            changes.push_back(*change);
        } else if (change) {
            problem = fmt::format("line {}: earlier than the line before: sort the lines by time", number);
        } else {
            problem = fmt::format("line {}: '{}' is not '{}': a time in ns, a standard deviation in s (0 to {:g}), a whole number", number, printable(line),
                                  heading, largest_sigma);
        }
    });
    if (!problem.empty()) return Error{problem};
    return changes;
}

Result<std::vector<TimeErrorChange>> read_time_errors(const std::filesystem::path& file) {
    const auto text = read_text(file);
    if (!text) return text.error();
    auto changes = parse_time_errors(*text);
    if (!changes) return Error{fmt::format("{}, {}", file.string(), changes.error().message)};
    return changes;
}

TimeError time_error_at(const std::vector<TimeErrorChange>& changes, Nanoseconds time) {
    const auto after = std::upper_bound(changes.begin(), changes.end(), time, [](Nanoseconds t, const TimeErrorChange& change) { return t < change.time; });
    return after == changes.begin() ? TimeError{} : std::prev(after)->error;
}

}  // namespace roomfix
