// Where each robot's frame `odom` is in the map, from its fixes and from what its wheels report a little earlier or later.
#pragma once

#include <deque>
#include <vector>

#include "roomfix/observation/odometry_observation.hpp"

namespace roomfix {

/// Of one robot.
class OdomCorrections {
public:
    struct Correction {
        Nanoseconds time = 0;
        Pose2 map_from_odom;
    };

    /// In the order of their times; others, and what is not finite, are ignored.
    void add_report(const OdometryObservation& report);
    void add_fix(Nanoseconds time, const Pose2& map_from_base);

    /// The corrections that are new, each of its own time: those of fixes for which the reports before and after are there. A fix waits for them for a
    /// second at most; `now` is the time of the newest that is known of anything.
    std::vector<Correction> take(Nanoseconds now);
    /// The last fix found no report beside it: nobody knows where `odom` is.
    bool missing_reports() const { return missing_reports_; }

private:
    struct Waiting {
        Nanoseconds time;
        Pose2 map_from_base;
    };
    std::vector<OdometryObservation> reports_;
    std::deque<Waiting> waiting_;
    Nanoseconds last_ = -1;  // time of the last correction
    bool missing_reports_ = false;
};

}  // namespace roomfix
