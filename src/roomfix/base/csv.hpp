// Lines of comma-separated values.
#pragma once

#include <string_view>
#include <vector>

namespace roomfix {

/// The fields of a line, without blanks around them. Quotes mean nothing.
std::vector<std::string_view> csv_fields(std::string_view line);

/// Place of a column in a header; -1: it has none of that name.
int csv_column(const std::vector<std::string_view>& header, std::string_view name);

/// A field of a line; empty where the column does not exist or the line is too short.
std::string_view csv_field(const std::vector<std::string_view>& fields, int column);

}  // namespace roomfix
