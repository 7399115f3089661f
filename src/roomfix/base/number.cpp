#include "roomfix/base/number.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "roomfix/base/csv.hpp"

namespace roomfix {

std::optional<double> parse_number(std::string_view text) {
    double value = 0;
    const char* end = text.data() + text.size();
    const char* begin = text.data();
    if (text.size() > 1 && text[0] == '+' && text[1] != '-') ++begin;
    const auto [stop, status] = std::from_chars(begin, end, value);
    if (status != std::errc() || stop != end || !std::isfinite(value)) return std::nullopt;
    return value;
}

std::optional<std::vector<double>> parse_numbers(std::string_view text) {
    std::vector<double> numbers;
    for (const std::string_view field : csv_fields(text)) {
        const auto number = parse_number(field);
        if (!number) return std::nullopt;
        numbers.push_back(*number);
    }
    return numbers;
}

std::optional<std::int64_t> parse_integer(std::string_view text) {
    std::int64_t value = 0;
    const char* end = text.data() + text.size();
    const auto [stop, status] = std::from_chars(text.data(), end, value);
    if (status != std::errc() || stop != end) return std::nullopt;
    return value;
}

std::string number_text(double value) {
    // Without exponent where that is readable: YAML 1.1 takes "8e-04" for a text.
    const double size = std::abs(value);
    const auto format = value == 0 || (size > 1e-12 && size < 1e15) ? std::chars_format::fixed : std::chars_format::scientific;
    std::array<char, 64> buffer;
    const auto [end, status] = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value, format);
    return status == std::errc() ? std::string(buffer.data(), end) : std::string("0");
}

std::optional<std::int64_t> parse_seconds(std::string_view text) {
    const bool negative = !text.empty() && text[0] == '-';
    if (negative) text.remove_prefix(1);
    const auto dot = std::min(text.find('.'), text.size());
    const std::string_view whole = text.substr(0, dot);
    std::string fraction(dot < text.size() ? text.substr(dot + 1) : std::string_view());
    const auto digits = [](std::string_view part) { return part.find_first_not_of("0123456789") == std::string_view::npos; };
    if ((whole.empty() && fraction.empty()) || whole.size() > 10 || !digits(whole) || !digits(fraction)) return std::nullopt;
    fraction.resize(9, '0');
    const auto seconds = parse_integer(whole.empty() ? "0" : whole);
    const auto rest = parse_integer(fraction);
    if (!seconds || !rest || *seconds > 9'000'000'000) return std::nullopt;
    const std::int64_t magnitude = *seconds * 1'000'000'000 + *rest;
    return negative ? -magnitude : magnitude;
}

std::string seconds_text(std::int64_t nanoseconds) {
    const bool negative = nanoseconds < 0;
    const std::uint64_t magnitude = negative ? ~static_cast<std::uint64_t>(nanoseconds) + 1 : static_cast<std::uint64_t>(nanoseconds);
    std::string fraction = std::to_string(magnitude % 1'000'000'000U);
    fraction.insert(0, 9 - fraction.size(), '0');
    while (fraction.size() > 1 && fraction.back() == '0') fraction.pop_back();
    return (negative ? "-" : "") + std::to_string(magnitude / 1'000'000'000U) + "." + fraction;
}

}  // namespace roomfix
