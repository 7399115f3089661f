#include "roomfix/evaluate/recorded_fixes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "roomfix/base/number.hpp"
#include "roomfix/base/text_file.hpp"
#include "roomfix/base/text_lines.hpp"

namespace roomfix {
namespace {

using nlohmann::json;

constexpr std::size_t most_problems = 20;

/// The time of a line with all its nanoseconds, which a double does not hold.
std::optional<Nanoseconds> exact_time(std::string_view line) {
    const std::size_t key = line.find("\"time\"");
    if (key == std::string_view::npos) return std::nullopt;
    const std::size_t begin = line.find_first_of("-0123456789", key + 6);
    if (begin == std::string_view::npos) return std::nullopt;
    const std::size_t end = line.find_first_not_of("-+.0123456789", begin);
    return parse_seconds(line.substr(begin, end == std::string_view::npos ? end : end - begin));
}

double finite_number(const json& object, const char* key) {
    const double value = object.at(key).get<double>();
    if (!std::isfinite(value)) throw std::runtime_error(fmt::format("'{}' is not finite", key));
    return value;
}

/// As many finite numbers as the matrix has, row by row.
template <class Matrix>
Matrix finite_numbers(const json& object, const char* key) {
    Matrix matrix;
    const json& numbers = object.at(key);
    if (!numbers.is_array() || numbers.size() != static_cast<std::size_t>(matrix.size())) {
        throw std::runtime_error(fmt::format("'{}' must have {} numbers", key, matrix.size()));
    }
    for (Eigen::Index i = 0; i < matrix.size(); ++i) matrix(i / matrix.cols(), i % matrix.cols()) = numbers[static_cast<std::size_t>(i)].get<double>();
    if (!matrix.allFinite()) throw std::runtime_error(fmt::format("'{}' is not finite", key));
    return matrix;
}

/// The id of a thing that is no robot; nothing for a fix of a robot, or of a camera that belongs to none. Throws as `read_fix`.
std::optional<std::string> unknown_thing(const json& object) {
    const auto robot = object.find("robot"), kind = object.find("kind");
    if (kind == object.end() || (robot != object.end() && !robot->is_null())) return std::nullopt;
    if (*kind != "unknown") throw std::runtime_error(fmt::format("kind {} is not \"unknown\"", kind->dump()));
    const auto id = object.find("id");
    if (id == object.end() || !id->is_string() || id->get<std::string>().empty()) throw std::runtime_error("an unknown thing needs an 'id'");
    return id->get<std::string>();
}

/// Throws what nlohmann throws, or std::runtime_error.
Fix read_fix(const json& object, Nanoseconds time, const std::optional<std::string>& thing) {
    Fix fix;
    fix.time = time;
    const auto robot = object.find("robot");
    if (thing) {
        fix.robot = *thing;
    } else if (robot != object.end() && robot->is_string()) {
        fix.robot = robot->get<std::string>();
    }
    const auto status = object.at("status").get<std::string>();
    if (status != "ok" && status != "coasting" && status != "none") throw std::runtime_error(fmt::format("status '{}' is not ok, coasting or none", status));
    if (const auto sources = object.find("sources"); sources != object.end()) fix.sources = sources->get<std::vector<std::string>>();
    if (status == "none") {
        fix.reason = object.value("reason", "");
        return fix;
    }
    fix.status = status == "ok" ? FixStatus::ok : FixStatus::coasting;
    fix.pose.x = finite_number(object, "x");
    fix.pose.y = finite_number(object, "y");
    fix.yaw_known = thing && !object.contains("yaw") ? false : !object.at("yaw").is_null();  // a thing need not say that nobody sees its front
    if (fix.yaw_known) fix.pose.yaw = finite_number(object, "yaw");
    fix.covariance = finite_numbers<Eigen::Matrix3d>(object, "covariance");
    if (object.contains("velocity")) {
        fix.velocity = finite_numbers<Eigen::Vector3d>(object, "velocity");
        fix.velocity_covariance = finite_numbers<Eigen::Matrix3d>(object, "velocity_covariance");
    }
    fix.identity = object.value("identity", 1.0);
    if (object.contains("latency")) fix.latency = finite_number(object, "latency");
    if (const auto nis = object.find("nis"); nis != object.end()) {
        for (const auto& [source, value] : nis->items()) fix.nis.push_back({source, value.at(0).get<double>(), value.at(1).get<int>()});
    }
    return fix;
}

}  // namespace

RecordedFixes parse_fixes(std::string_view text) {
    RecordedFixes recorded;
    each_line(text, [&](std::string_view line, long number) {
        std::string problem;
        try {
            const auto time = exact_time(line);
            const json object = json::parse(line);
            if (!time) throw std::runtime_error("it has no 'time' in seconds");
            const auto thing = unknown_thing(object);
            (thing ? recorded.unknown_things : recorded.fixes).push_back(read_fix(object, *time, thing));
        } catch (const std::exception& failure) {
            problem = failure.what();
        }
        if (!problem.empty() && recorded.problems.size() < most_problems) recorded.problems.push_back(fmt::format("line {}: {}", number, problem));
    });
    for (std::vector<Fix>* fixes : {&recorded.fixes, &recorded.unknown_things}) {
        std::stable_sort(fixes->begin(), fixes->end(), [](const Fix& a, const Fix& b) { return a.time < b.time; });
    }
    return recorded;
}

Result<RecordedFixes> load_fixes(const std::string& file) {
    const auto text = read_text(file);
    if (!text) return Error{file + ": cannot be opened: check the name and the permissions"};
    RecordedFixes recorded = parse_fixes(*text);
    if (recorded.fixes.empty() && recorded.unknown_things.empty()) {
        return Error{fmt::format("{}: no fix in it{}", file, recorded.problems.empty() ? ": it is empty" : "; " + recorded.problems.front())};
    }
    return recorded;
}

}  // namespace roomfix
