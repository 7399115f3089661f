#include "roomfix/connect/sender_reports.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "roomfix/base/median.hpp"

namespace roomfix {
namespace {

constexpr double report_bin = 1;           // s of the media clock
constexpr std::size_t reports_kept = 30;   // bins
constexpr double told_drift_needs = 15;    // s of reports from which a drift is told
constexpr double oscillator_drift = 5e-4;  // s/s: what a camera's oscillator does at most
constexpr double clock_jump = 2;           // s by which a clock that was set anew is off

}  // namespace

/// Theil's line: the middle of the slopes between all pairs of points, the middle of what is left.
void SenderReports::fit() {
    slope_ = 0;
    from_ = points_.back().media;
    if (from_ - points_.front().media >= told_drift_needs) {
        std::vector<double> slopes;
        for (std::size_t i = 0; i < points_.size(); ++i) {
            for (std::size_t j = 0; j < i; ++j) slopes.push_back((points_[i].offset - points_[j].offset) / (points_[i].media - points_[j].media));
        }
        slope_ = std::clamp(median(slopes), -oscillator_drift, oscillator_drift);
    }
    std::vector<double> levels;
    for (const Point& point : points_) levels.push_back(point.offset - slope_ * (point.media - from_));
    level_ = median(levels);
    spread_ = 0;
    for (const double level : levels) spread_ += std::abs(level - level_) / static_cast<double>(levels.size());
}

Nanoseconds SenderReports::corrected(double media, Nanoseconds wall) {
    if (points_.empty()) {
        first_wall_ = wall;
        first_media_ = media;
    }
    const double since = media - first_media_;
    const double offset = to_seconds(wall - first_wall_) - since;
    if (!points_.empty() && (since < points_.back().media - clock_jump || std::abs(offset - level_) > clock_jump)) {
        clear();
        return corrected(media, wall);
    }
    if (points_.empty() || since > points_.back().media + report_bin) {
        points_.push_back({since, offset});
        if (points_.size() > reports_kept) points_.pop_front();
        fit();
    }
    last_off_ = offset - level_ - slope_ * (since - from_);
    return wall - from_seconds(last_off_);
}

}  // namespace roomfix
