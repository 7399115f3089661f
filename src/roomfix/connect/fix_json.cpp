#include "roomfix/connect/fix_json.hpp"

#include <nlohmann/json.hpp>

#include "roomfix/base/number.hpp"

namespace roomfix {
namespace {

std::string quoted(const std::string& text) { return nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace); }

/// A length or angle with as many digits as anybody can use.
std::string rounded(double value) { return number_text(std::round(value * 1e6) / 1e6); }

std::string pose_fields(const Pose2& pose, bool yaw_known) {
    return "\"x\": " + rounded(pose.x) + ", \"y\": " + rounded(pose.y) + ", \"yaw\": " + (yaw_known ? rounded(pose.yaw) : "null");
}

/// Nine significant decimals keep the matrix positive definite and the line readable.
std::string covariance_text(const Eigen::Matrix3d& covariance) {
    std::string text = "[";
    for (int i = 0; i < 9; ++i) {
        const double value = covariance(i / 3, i % 3);
        const double scale = value == 0 ? 1 : std::pow(10.0, 8 - std::floor(std::log10(std::abs(value))));
        text += (i ? ", " : "") + number_text(std::round(value * scale) / scale);
    }
    return text + "]";
}

std::string velocity_fields(const Eigen::Vector3d& velocity, const Eigen::Matrix3d& covariance) {
    const std::string text = rounded(velocity.x()) + ", " + rounded(velocity.y()) + ", " + rounded(velocity.z());
    return ", \"velocity\": [" + text + "], \"velocity_covariance\": " + covariance_text(covariance);
}

}  // namespace

const char* name_of(FixStatus status) {
    if (status == FixStatus::ok) return "ok";
    return status == FixStatus::coasting ? "coasting" : "none";
}

std::string fix_line(const Fix& fix) {
    // Written by hand: times need all their nanoseconds, and the order of the keys is part of the format.
    std::string line = "{\"time\": " + seconds_text(fix.time) + ", \"robot\": " + (fix.robot.empty() || fix.unknown ? "null" : quoted(fix.robot));
    if (fix.unknown) line += ", \"kind\": \"unknown\", \"id\": " + quoted(fix.robot);
    line += std::string(", \"status\": \"") + name_of(fix.status) + "\"";
    if (fix.status == FixStatus::none) {
        line += ", \"reason\": " + quoted(fix.reason);
    } else {
        line += ", " + pose_fields(fix.pose, fix.yaw_known) + ", \"covariance\": " + covariance_text(fix.covariance);
        if (fix.velocity) line += velocity_fields(*fix.velocity, fix.velocity_covariance);
    }
    if (fix.map_from_camera) {
        const Eigen::Vector3d& p = fix.map_from_camera->translation();
        const Eigen::Quaterniond q(fix.map_from_camera->linear());
        line += ", \"camera\": {\"position\": [" + rounded(p.x()) + ", " + rounded(p.y()) + ", " + rounded(p.z()) + "], \"quaternion\": [" +
                number_text(q.x()) + ", " + number_text(q.y()) + ", " + number_text(q.z()) + ", " + number_text(q.w()) + "]}";
    }
    line += ", \"sources\": [";
    for (std::size_t i = 0; i < fix.sources.size(); ++i) line += (i ? ", " : "") + quoted(fix.sources[i]);
    line += "]";
    if (fix.existence < 0.9995) line += ", \"existence\": " + number_text(std::round(fix.existence * 1e3) / 1e3);
    if (fix.identity < 0.9995) line += ", \"identity\": " + number_text(std::round(fix.identity * 1e3) / 1e3);
    if (fix.latency) line += ", \"latency\": " + rounded(*fix.latency);
    if (const auto& parts = fix.latency_parts) {
        line += ", \"latency_parts\": {\"waiting\": " + rounded(parts->waiting) + ", \"looking\": " + rounded(parts->looking) +
                ", \"fitting\": " + rounded(parts->fitting) + ", \"tracking\": " + rounded(parts->tracking) + "}";
    }
    if (!fix.nis.empty()) {
        line += ", \"nis\": {";
        for (std::size_t i = 0; i < fix.nis.size(); ++i) {
            line += (i ? ", " : "") + quoted(fix.nis[i].source) + ": [" + number_text(std::round(fix.nis[i].nis * 1e3) / 1e3) + ", " +
                    std::to_string(fix.nis[i].dimensions) + "]";
        }
        line += "}";
    }
    if (!fix.image.empty()) line += ", \"image\": " + quoted(fix.image);
    if (fix.hypotheses.size() > 1) {
        line += ", \"hypotheses\": [";
        for (std::size_t i = 0; i < fix.hypotheses.size(); ++i) {
            line += (i ? ", {" : "{") + pose_fields(fix.hypotheses[i].pose, fix.yaw_known) + ", \"weight\": " + rounded(fix.hypotheses[i].weight) + "}";
        }
        line += "]";
    }
    return line + "}";
}

}  // namespace roomfix
