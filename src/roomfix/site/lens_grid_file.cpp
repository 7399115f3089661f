#include "roomfix/site/lens_grid_file.hpp"

#include <fmt/format.h>

#include <array>

#include "roomfix/base/csv.hpp"
#include "roomfix/base/number.hpp"
#include "roomfix/base/text_file.hpp"

namespace roomfix {
namespace {

constexpr std::string_view heading = "column,row,u,v,ideal_u,ideal_v";
constexpr std::size_t most_points = 1'000'000;

std::optional<std::array<double, 6>> numbers_of(std::string_view line) {
    std::array<double, 6> numbers;
    const auto fields = csv_fields(line);
    if (fields.size() != numbers.size()) return std::nullopt;
    for (std::size_t i = 0; i < numbers.size(); ++i) {
        const auto value = parse_number(fields[i]);
        if (!value) return std::nullopt;
        numbers[i] = *value;
    }
    return numbers;
}

}  // namespace

Result<LensGrid> parse_lens_grid(std::string_view text) {
    std::vector<Eigen::Vector2d> seen, ideal;
    int columns = 0;
    for (std::size_t number = 1; !text.empty(); ++number) {
        const auto end = text.find('\n');
        std::string_view line = text.substr(0, end);
        text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
        if (line.ends_with('\r')) line.remove_suffix(1);
        if (number == 1) {
            if (line != heading) return Error{fmt::format("line 1: a lens grid begins with {}", heading)};
            continue;
        }
        if (line.empty()) continue;
        const auto fields = numbers_of(line);
        if (!fields) return Error{fmt::format("line {}: six numbers are needed: {}", number, heading)};
        const auto [column, row, u, v, ideal_u, ideal_v] = *fields;
        if (row == 0 && column == columns) ++columns;
        const bool next = columns > 0 && column == static_cast<double>(seen.size() % static_cast<std::size_t>(columns)) &&
                          row == static_cast<double>(seen.size() / static_cast<std::size_t>(columns));
        if (!next || seen.size() == most_points) return Error{fmt::format("line {}: points must come row by row, each once", number)};
        seen.emplace_back(u, v);
        ideal.emplace_back(ideal_u, ideal_v);
    }
    return LensGrid::create(columns, std::move(seen), std::move(ideal));
}

Result<LensGrid> load_lens_grid(const std::filesystem::path& file) {
    const auto text = read_text(file);
    if (!text) return text.error();
    auto grid = parse_lens_grid(*text);
    if (!grid) return Error{fmt::format("{}: {}", file.string(), grid.error().message)};
    return grid;
}

std::string lens_grid_text(const LensGrid& grid) {
    std::string text = std::string(heading) + "\n";
    for (std::size_t i = 0; i < grid.seen().size(); ++i) {
        const auto across = static_cast<std::size_t>(grid.columns());
        text += fmt::format("{},{},{},{},{},{}\n", i % across, i / across, number_text(grid.seen()[i].x()), number_text(grid.seen()[i].y()),
                            number_text(grid.ideal()[i].x()), number_text(grid.ideal()[i].y()));
    }
    return text;
}

}  // namespace roomfix
