#include "roomfix/evaluate/recorded_fixes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "roomfix/base/number.hpp"

namespace roomfix {
namespace {

using nlohmann::json;

constexpr std::size_t most_problems = 20;

Result<std::string> text_of(const std::string& file) {
    std::ifstream stream(file, std::ios::binary);
    if (!stream) return Error{fmt::format("{}: cannot be opened: check the name and the permissions", file)};
    std::ostringstream text;
    text << stream.rdbuf();
    return text.str();
}

/// Calls `take(line, number)` for each line that is not blank.
template <class Take>
void each_line(std::string_view text, const Take& take) {
    for (long number = 1; !text.empty(); ++number) {
        const std::size_t end = text.find('\n');
        std::string_view line = text.substr(0, end);
        text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
        if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
        if (line.find_first_not_of(" \t") != std::string_view::npos) take(line, number);
    }
}

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

/// Throws what nlohmann throws, or std::runtime_error.
Fix read_fix(const json& object, Nanoseconds time) {
    Fix fix;
    fix.time = time;
    const auto robot = object.find("robot");
    if (robot != object.end() && robot->is_string()) fix.robot = robot->get<std::string>();
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
    fix.yaw_known = !object.at("yaw").is_null();
    if (fix.yaw_known) fix.pose.yaw = finite_number(object, "yaw");
    const json& covariance = object.at("covariance");
    if (!covariance.is_array() || covariance.size() != 9) throw std::runtime_error("'covariance' must have 9 numbers");
    for (int i = 0; i < 9; ++i) fix.covariance(i / 3, i % 3) = covariance[static_cast<std::size_t>(i)].get<double>();
    if (!fix.covariance.allFinite()) throw std::runtime_error("'covariance' is not finite");
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
            recorded.fixes.push_back(read_fix(object, *time));
        } catch (const std::exception& failure) {
            problem = failure.what();
        }
        if (!problem.empty() && recorded.problems.size() < most_problems) recorded.problems.push_back(fmt::format("line {}: {}", number, problem));
    });
    std::stable_sort(recorded.fixes.begin(), recorded.fixes.end(), [](const Fix& a, const Fix& b) { return a.time < b.time; });
    return recorded;
}

Result<RecordedFixes> load_fixes(const std::string& file) {
    const auto text = text_of(file);
    if (!text) return text.error();
    RecordedFixes recorded = parse_fixes(*text);
    if (recorded.fixes.empty()) {
        return Error{fmt::format("{}: no fix in it{}", file, recorded.problems.empty() ? ": it is empty" : "; " + recorded.problems.front())};
    }
    return recorded;
}

Result<Truth> parse_truth(std::string_view text) {
    Truth truth;
    std::string failure;
    bool header = false;
    each_line(text, [&](std::string_view line, long number) {
        if (!failure.empty()) return;
        std::array<std::string_view, 5> fields;
        std::size_t count = 0;
        for (std::string_view rest = line; count < 5; ++count) {
            const std::size_t comma = rest.find(',');
            fields[count] = rest.substr(0, comma);
            if (comma == std::string_view::npos) {
                ++count;
                break;
            }
            rest.remove_prefix(comma + 1);
        }
        if (!header) {
            header = true;
            if (count < 5 || fields[0] != "time" || fields[1] != "robot" || fields[2] != "x" || fields[3] != "y" || fields[4] != "yaw") {
                failure = "the first line must be time,robot,x,y,yaw";
            }
            return;
        }
        const auto time = parse_seconds(fields[0]);
        const auto x = parse_number(fields[2]), y = parse_number(fields[3]), yaw = parse_number(fields[4]);
        if (!time || !x || !y || !yaw) {
            failure = fmt::format("line {}: '{}' is not time,robot,x,y,yaw", number, line);
            return;
        }
        truth[std::string(fields[1])].push_back({*time, {*x, *y, *yaw}});
    });
    if (failure.empty() && truth.empty()) failure = "it holds no poses";
    if (!failure.empty()) return Error{failure};
    for (auto& [robot, poses] : truth) {
        std::stable_sort(poses.begin(), poses.end(), [](const StampedPose& a, const StampedPose& b) { return a.time < b.time; });
    }
    return truth;
}

Result<Truth> load_truth(const std::string& file) {
    const auto text = text_of(file);
    if (!text) return text.error();
    auto truth = parse_truth(*text);
    if (!truth) return Error{file + ": " + truth.error().message};
    return truth;
}

std::optional<Pose2> pose_at(const std::vector<StampedPose>& poses, Nanoseconds time, double gap) {
    const auto next = std::lower_bound(poses.begin(), poses.end(), time, [](const StampedPose& p, Nanoseconds t) { return p.time < t; });
    if (next == poses.end()) return std::nullopt;
    if (next->time == time) return next->pose;
    if (next == poses.begin()) return std::nullopt;
    const StampedPose& before = *(next - 1);
    if (to_seconds(next->time - before.time) > gap) return std::nullopt;
    const double part = to_seconds(time - before.time) / to_seconds(next->time - before.time);
    const auto between = [&](double a, double b) { return a + part * (b - a); };
    const double yaw = before.pose.yaw + part * wrap_angle(next->pose.yaw - before.pose.yaw);
    return Pose2{between(before.pose.x, next->pose.x), between(before.pose.y, next->pose.y), wrap_angle(yaw)};
}

std::string tum_text(const std::vector<StampedPose>& poses) {
    std::string text;
    for (const StampedPose& p : poses) {
        text += fmt::format("{} {} {} 0 0 0 {} {}\n", seconds_text(p.time), number_text(p.pose.x), number_text(p.pose.y),
                            number_text(std::sin(0.5 * p.pose.yaw)), number_text(std::cos(0.5 * p.pose.yaw)));
    }
    return text;
}

}  // namespace roomfix
