#include "roomfix/pipeline/zone_watch.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>

namespace roomfix {
namespace {

/// Distance from the origin to the line between two points.
double distance_to(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    const Eigen::Vector2d along = b - a;
    const double length = along.squaredNorm();
    const double t = length > 0 ? std::clamp(-a.dot(along) / length, 0.0, 1.0) : 0.0;
    return (a + t * along).norm();
}

/// Does a ray from the origin to the right cross the line between two points? An odd number of crossings is within.
bool crosses(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    if ((a.y() > 0) == (b.y() > 0)) return false;
    return a.x() + (b.x() - a.x()) * a.y() / (a.y() - b.y()) > 0;
}

}  // namespace

double probability_within(const Polyline& border, const Eigen::Vector2d& place, const Eigen::Matrix2d& covariance) {
    const Eigen::LLT<Eigen::Matrix2d> root(covariance);
    double nearest = std::numeric_limits<double>::infinity();
    bool within = false;
    for (std::size_t i = 0; i < border.size(); ++i) {
        // In units of standard deviations, seen from the place.
        const Eigen::Vector2d a = root.matrixL().solve(border[i] - place);
        const Eigen::Vector2d b = root.matrixL().solve(border[(i + 1) % border.size()] - place);
        nearest = std::min(nearest, distance_to(a, b));
        if (crosses(a, b)) within = !within;
    }
    const double beyond = 0.5 * std::erfc(nearest / std::numbers::sqrt2);
    return within ? 1 - beyond : beyond;
}

void ZoneWatch::watch(FixBatch& batch) {
    const auto add = [&](std::vector<ZoneEvent> events) { std::move(events.begin(), events.end(), std::back_inserter(batch.zone_events)); };
    for (const Fix& fix : batch.given) {
        if (!fix.unknown) add(update(fix));
    }
    std::vector<std::string> gone;
    for (const auto& [robot, zones] : within_) {
        const auto is_it = [&name = robot](const Fix& fix) { return fix.robot == name; };
        if (std::none_of(batch.all.begin(), batch.all.end(), is_it)) gone.push_back(robot);
    }
    for (const std::string& robot : gone) add(forget(robot, batch.time));
    for (const auto& [robot, zones] : within_) {
        if (auto names = zones_of(robot); !names.empty()) batch.zones[robot] = std::move(names);
    }
}

std::vector<ZoneEvent> ZoneWatch::update(const Fix& fix) {
    std::vector<ZoneEvent> events;
    if (fix.status == FixStatus::none || fix.robot.empty()) return events;
    std::set<std::string>& within = within_[fix.robot];
    for (const SiteZone& zone : zones_) {
        const double probability = probability_within(zone.border, {fix.pose.x, fix.pose.y}, fix.covariance.topLeftCorner<2, 2>());
        const bool was = within.contains(zone.id);
        const bool is = was ? probability > settings_.outside : probability >= settings_.inside;
        if (is == was) continue;
        if (is) {
            within.insert(zone.id);
        } else {
            within.erase(zone.id);
        }
        events.push_back({fix.time, zone.id, fix.robot, is});
    }
    return events;
}

std::vector<ZoneEvent> ZoneWatch::forget(const std::string& robot, Nanoseconds time) {
    std::vector<ZoneEvent> events;
    for (const std::string& zone : zones_of(robot)) events.push_back({time, zone, robot, false});
    within_.erase(robot);
    return events;
}

std::vector<std::string> ZoneWatch::zones_of(const std::string& robot) const {
    std::vector<std::string> names;
    const auto found = within_.find(robot);
    if (found == within_.end()) return names;
    for (const SiteZone& zone : zones_) {
        if (found->second.contains(zone.id)) names.push_back(zone.id);
    }
    return names;
}

}  // namespace roomfix
