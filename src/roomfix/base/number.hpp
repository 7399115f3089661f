// Numbers as text, the same in every locale.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace roomfix {

/// The whole of `text` as a finite decimal number (no leading or trailing blanks, no "nan" or "inf"); nothing otherwise.
std::optional<double> parse_number(std::string_view text);

/// Finite decimal numbers between commas, with blanks or not, at least one; nothing otherwise.
std::optional<std::vector<double>> parse_numbers(std::string_view text);

/// The whole of `text` as a decimal integer; nothing otherwise, also on overflow.
std::optional<std::int64_t> parse_integer(std::string_view text);

/// Decimal seconds without loss as nanoseconds: "12.345678901" -> 12345678901. Nothing for other texts and beyond +-9e9 s;
/// digits after the ninth decimal are cut off.
std::optional<std::int64_t> parse_seconds(std::string_view text);

/// The shortest text that reads back as the same number, with a dot as decimal point.
std::string number_text(double value);

/// Nanoseconds as decimal seconds without loss: 12345678901 -> "12.345678901".
std::string seconds_text(std::int64_t nanoseconds);

}  // namespace roomfix
