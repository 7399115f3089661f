#include "roomfix/pipeline/odom_corrections.hpp"

#include <algorithm>
#include <cmath>

#include "roomfix/connect/ros_fix.hpp"
#include "roomfix/pipeline/odometry_poses.hpp"

namespace roomfix {
namespace {

constexpr Nanoseconds second = 1'000'000'000;
constexpr Nanoseconds kept = 5 * second;      // reports
constexpr Nanoseconds longest_wait = second;  // for a report

}  // namespace

void OdomCorrections::add_report(const OdometryObservation& report) {
    const bool finite = std::isfinite(report.pose.x) && std::isfinite(report.pose.y) && std::isfinite(report.pose.yaw);
    if (!finite || (!reports_.empty() && report.time <= reports_.back().time)) return;
    reports_.push_back(report);
    std::erase_if(reports_, [&](const OdometryObservation& old) { return old.time < report.time - kept; });
}

void OdomCorrections::add_fix(Nanoseconds time, const Pose2& map_from_base) {
    // Of two fixes of one time the later one knows more.
    if (!waiting_.empty() && waiting_.back().time == time) waiting_.pop_back();
    if (time > last_ && (waiting_.empty() || time > waiting_.back().time)) waiting_.push_back({time, map_from_base});
}

std::vector<OdomCorrections::Correction> OdomCorrections::take(Nanoseconds now) {
    std::vector<Correction> corrections;
    while (!waiting_.empty()) {
        const Waiting fix = waiting_.front();
        const bool report_may_come = reports_.empty() || reports_.back().time < fix.time;
        if (report_may_come && now - fix.time <= longest_wait) break;
        waiting_.pop_front();
        const auto odom_from_base = odometry_at(reports_, fix.time);
        missing_reports_ = !odom_from_base;
        if (!odom_from_base) continue;
        corrections.push_back({fix.time, ros::map_from_odom(fix.map_from_base, *odom_from_base)});
        last_ = fix.time;
    }
    return corrections;
}

}  // namespace roomfix
