// How far the times of recorded frames may be off: a file beside the frames.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "roomfix/base/result.hpp"
#include "roomfix/base/time.hpp"
#include "roomfix/observation/time_error.hpp"

namespace roomfix {

/// In the folder of a camera's frames, where their times are not sure.
constexpr std::string_view time_errors_name = "time-errors.csv";
/// The file's first line.
constexpr std::string_view time_error_columns = "nanoseconds,sigma,way\n";

/// From this frame on.
struct TimeErrorChange {
    Nanoseconds time = 0;
    TimeError error;
};
std::string time_error_line(const TimeErrorChange& change);

/// In the order of their times. An error names the line.
Result<std::vector<TimeErrorChange>> parse_time_errors(std::string_view text);
/// An error names the file, too.
Result<std::vector<TimeErrorChange>> read_time_errors(const std::filesystem::path& file);

/// Of a frame of that time.
TimeError time_error_at(const std::vector<TimeErrorChange>& changes, Nanoseconds time);

}  // namespace roomfix
