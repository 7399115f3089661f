#include "roomfix/connect/sighting_source.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "roomfix/base/csv.hpp"
#include "roomfix/base/number.hpp"
#include "roomfix/base/text_file.hpp"
#include "roomfix/connect/json_text.hpp"
#include "roomfix/connect/sensed_lines.hpp"

namespace roomfix {
namespace {

constexpr std::size_t most_problems = 20;
constexpr double farthest_seen = 1000;  // m: nothing indoors is seen from farther

/// What a line says, as text; empty: it does not say.
struct SightingText {
    std::string time, robot, landmark, range, bearing, range_sigma, bearing_sigma;
};

Result<SightingText> text_of_json(std::string_view line) {
    const auto json = nlohmann::json::parse(line, nullptr, false);
    if (json.is_discarded() || !json.is_object()) return Error{"it is no JSON object"};
    return SightingText{json_text(json, "time"),    json_text(json, "robot"),       json_text(json, "landmark"),     json_text(json, "range"),
                        json_text(json, "bearing"), json_text(json, "range_sigma"), json_text(json, "bearing_sigma")};
}

SightingText text_of_csv(std::string_view line, const std::vector<std::string_view>& header) {
    const auto fields = csv_fields(line);
    const auto field = [&](std::string_view name) { return std::string(csv_field(fields, csv_column(header, name))); };
    return {field("time"), field("robot"), field("landmark"), field("range"), field("bearing"), field("range_sigma"), field("bearing_sigma")};
}

std::optional<int> landmark_index(const Site& site, const std::string& id) {
    for (std::size_t i = 0; i < site.landmarks.size(); ++i) {
        if (site.landmarks[i].id == id) return static_cast<int>(i);
    }
    return std::nullopt;
}

/// A positive standard deviation, or what is usual where the text is empty.
Result<double> sigma_of(const std::string& text, double usual) {
    if (text.empty()) return usual;
    const auto number = parse_number(text);
    if (!number || !(*number > 0) || *number > farthest_seen) return Error{fmt::format("'{}' is no standard deviation: it must be positive", text)};
    return *number;
}

Result<SightingObservation> sighting_of(const SightingText& text, const Site& site, int robot) {
    SightingObservation sighting;
    const auto time = parse_seconds(text.time);
    if (!time) return Error{fmt::format("'{}' is no time in seconds", text.time)};
    sighting.time = *time;
    sighting.robot = robot;
    if (!text.robot.empty()) {
        const auto index = site.robot(text.robot);
        if (!index) return Error{fmt::format("the site has no robot '{}'", text.robot)};
        sighting.robot = *index;
    }
    if (sighting.robot < 0) return Error{"it names no robot: add a column 'robot'"};
    if (!text.landmark.empty()) {
        const auto landmark = landmark_index(site, text.landmark);
        if (!landmark) return Error{fmt::format("unknown landmark '{}': add it under 'landmarks' with its position, or leave the field empty", text.landmark)};
        sighting.landmark = *landmark;
    }
    if (!text.range.empty()) {
        sighting.range = parse_number(text.range);
        if (!sighting.range || !(*sighting.range > 0) || *sighting.range > farthest_seen) {
            return Error{fmt::format("'{}' is no range: it must lie between 0 and {} m", text.range, number_text(farthest_seen))};
        }
    }
    if (!text.bearing.empty()) {
        sighting.bearing = parse_number(text.bearing);
        if (!sighting.bearing || std::abs(*sighting.bearing) > 6.3) {
            return Error{fmt::format("'{}' is no bearing: it must lie between -6.3 and 6.3 rad; is it in degrees?", text.bearing)};
        }
    }
    if (!sighting.range && !sighting.bearing) return Error{"it has neither a range nor a bearing"};
    const Detector detector = site.robots[static_cast<std::size_t>(sighting.robot)].detector.value_or(Detector{});
    const auto range_sigma = sigma_of(text.range_sigma, detector.range_sigma);
    if (!range_sigma) return range_sigma.error();
    const auto bearing_sigma = sigma_of(text.bearing_sigma, detector.bearing_sigma);
    if (!bearing_sigma) return bearing_sigma.error();
    sighting.range_sigma = *range_sigma;
    sighting.bearing_sigma = *bearing_sigma;
    return sighting;
}

}  // namespace

Result<SightingBatch> parse_sightings(std::string_view text, const Site& site, int robot) {
    SightingBatch batch;
    std::optional<std::vector<std::string_view>> header;
    long number = 0;
    bool read = false;
    while (!text.empty()) {
        const std::size_t end = text.find('\n');
        const std::string_view line = text.substr(0, end);
        text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
        ++number;
        const std::size_t first = line.find_first_not_of(" \t\r");
        if (first == std::string_view::npos || line[first] == '#') continue;
        const bool json = line[first] == '{';
        if (!json && !header) {
            header = csv_fields(line);
            const bool fits = csv_column(*header, "time") >= 0 && (csv_column(*header, "range") >= 0 || csv_column(*header, "bearing") >= 0);
            if (!fits) return Error{"the first line must name the columns time,robot,landmark,range,bearing[,range_sigma,bearing_sigma]"};
            read = true;
            continue;
        }
        read = true;
        const auto said = json ? text_of_json(line) : Result<SightingText>(text_of_csv(line, *header));
        const auto sighting = said ? sighting_of(*said, site, robot) : Result<SightingObservation>(said.error());
        if (sighting) {
            batch.sightings.push_back(*sighting);
        } else if (batch.problems.size() < most_problems) {
            batch.problems.push_back(fmt::format("line {}: {}", number, sighting.error().message));
        }
    }
    if (!read) return Error{"it is empty: the first line must name the columns time,robot,landmark,range,bearing[,range_sigma,bearing_sigma]"};
    return batch;
}

Result<SightingBatch> load_sightings(const std::string& file, const Site& site, int robot) {
    const auto sensed = read_sensed(file);
    if (!sensed) return Error{sensed.error().message + " (the detector's 'source')"};
    auto batch = parse_sightings(sensed->text, site, robot);
    if (!batch) return Error{file + ": " + batch.error().message};
    if (!sensed->note.empty()) batch->problems.push_back(sensed->note);
    for (std::string& problem : batch->problems) problem.insert(0, file + ", ");
    return batch;
}

}  // namespace roomfix
