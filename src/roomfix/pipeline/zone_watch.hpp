// Which zones robots are in, and when they enter and leave them.
#pragma once

#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "roomfix/pipeline/fix_sink.hpp"
#include "roomfix/site/site.hpp"

namespace roomfix {

/// How probable it is that a place with this covariance (m^2) lies within a border, as if the border were straight beyond the point of it that is nearest in
/// standard deviations.
double probability_within(const Polyline& border, const Eigen::Vector2d& place, const Eigen::Matrix2d& covariance);

struct ZoneSettings {
    double inside = 0.95;   // a robot enters where it is within with this probability,
    double outside = 0.05;  // and leaves where it is with this one; in between it is where it was: noise at a border is no event
};

/// One for all outputs, before the fixes get there: they all tell the same.
class ZoneWatch {
public:
    explicit ZoneWatch(std::vector<SiteZone> zones, const ZoneSettings& settings = {}) : zones_(std::move(zones)), settings_(settings) {}

    /// Puts into a batch what its given fixes change, and who is where. Robots that are no longer among all of them are gone for good.
    void watch(FixBatch& batch);
    /// Others from now on; robots stay in those whose names stay, until a fix says otherwise.
    void set_zones(std::vector<SiteZone> zones) { zones_ = std::move(zones); }
    const std::vector<SiteZone>& zones() const { return zones_; }

    /// What a fix changes. A fix without a place changes nothing.
    std::vector<ZoneEvent> update(const Fix& fix);
    /// A robot that is gone for good leaves all zones.
    std::vector<ZoneEvent> forget(const std::string& robot, Nanoseconds time);
    /// In the order of the site file.
    std::vector<std::string> zones_of(const std::string& robot) const;

private:
    std::vector<SiteZone> zones_;
    ZoneSettings settings_;
    std::map<std::string, std::set<std::string>> within_;  // zones of each robot
};

}  // namespace roomfix
