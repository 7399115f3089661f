// Fixes beside the truth: how far off, how often, how honest.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "roomfix/evaluate/consistency.hpp"
#include "roomfix/evaluate/gospa.hpp"
#include "roomfix/evaluate/hota.hpp"
#include "roomfix/evaluate/idf1.hpp"
#include "roomfix/evaluate/recorded_fixes.hpp"
#include "roomfix/evaluate/truth.hpp"
#include "roomfix/evaluate/unknown_things.hpp"

namespace roomfix {

/// One fix with its error.
struct JudgedFix {
    Nanoseconds time = 0;
    std::string robot, sources;
    bool coasting = false;
    Pose2 fix, truth;
    bool fix_has_yaw = true, truth_has_yaw = true;
    Eigen::Vector3d error = Eigen::Vector3d::Zero();  // fix - truth; m, m, rad (0 where a yaw is missing)
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();
    double nees = 0;  // of x, y, and of yaw where both have one
    int dimensions = 3;
    std::optional<double> bound;  // m: root of the trace of the bound of x and y

    bool yaw_judged() const { return fix_has_yaw && truth_has_yaw; }
};

/// A mean of normalised squares beside what truthful covariances give.
struct Consistency {
    double mean = 0;              // per dimension: 1 is truthful
    double low = 0, high = 0;     // 95 % band of that mean
    std::size_t independent = 0;  // fixes that count as independent: two seconds apart
};

/// What a group of fixes is worth.
struct ErrorTable {
    std::string name;
    Summary position;  // m
    Summary yaw;       // rad, where fix and truth have a yaw
    Consistency nees;
    double stated_sigma = 0;  // m: rms of what the covariances say of the place
    double bound = 0;         // m: rms of what any tracker could reach with the same observations; 0: not known
    double over_bound = 0;    // rmse over the bound, of the fixes that have one; 1 is the best there can be
};

/// Fixes of status ok that are far off.
struct ConfidentlyWrong {
    double farther_than = 0.5;  // m from the truth
    std::size_t fixes = 0;      // of status ok
    std::size_t wrong = 0;
    double stated_sigma = 0;  // m: median of what the wrong ones state of their place

    double part() const { return fixes > 0 ? static_cast<double>(wrong) / static_cast<double>(fixes) : 0; }
};

struct ErrorReport {
    ErrorTable all;
    std::vector<ErrorTable> robots, sources;
    Summary relative_position;  // m: error of the way driven in one second, in the robot's frame where its yaw is known
    Summary relative_yaw;       // rad
    double availability = 0;    // part of the true time that has a fix that is not older than `fresh`
    double coasting = 0;        // part of the fixes
    Summary latency;            // s, of fixes that state one
    int identity_switches = 0;  // a robot's name moves to another robot
    int flagged_switches = 0;   // of these: `identity` said that it was doubtful
    int misnamed = 0;           // names that were another robot's from the start
    int flagged_misnamed = 0;   // of these: `identity` said that it was doubtful
    double followed_rms = 0;    // m, of the fixes from the robots that their names follow, whatever these are called
    Gospa gospa;                // of all robots, as are the next two
    IdentityScore identities;
    Hota hota;
    ConfidentlyWrong confidently_wrong;
    UnknownThings unknown_things;
    std::vector<std::pair<std::string, Consistency>> nis;  // by source, where the fixes state it
    std::vector<std::string> unknown_robots;               // in the fixes, not in the truth
    std::size_t without_true_yaw = 0;                      // fixes with a yaw beside a truth without one
    std::map<std::string, std::size_t> without_point;      // of each robot: fixes left out, since without a yaw nobody knows where the point is
    std::vector<JudgedFix> fixes;
};

struct ReportOptions {
    double symmetry = 0;                              // rad: yaws that many apart are the same; 0: none are
    double fresh = 0.25;                              // s
    double apart = 0.5;                               // m: a fix so near to another robot and farther from its own has the wrong name
    double cutoff = 1;                                // m: of GOSPA, IDF1, HOTA; a fix farther from a target is not about it
    double on_thing = 0.3;                            // m: a robot's fix so near to an unknown thing and not `apart`-near to its robot stands on the thing
    Eigen::Vector2d point = Eigen::Vector2d::Zero();  // m, robot frame: the point that the truth is about
};

/// Robots of which there are many ("cart-3") are compared with the nearest of that kind. Where the truth has no yaw, x and y are judged alone.
/// Unknown things in the truth are no robots and have figures of their own.
/// `bounds`: of each fix, as `tracking_bounds` finds them; may be empty.
ErrorReport judge(const RecordedFixes& recorded, const Truth& truth, const ReportOptions& options = {},
                  const std::vector<std::optional<Eigen::Matrix3d>>& bounds = {});

/// For the terminal.
std::string text_of(const ErrorReport& report);
std::string json_of(const ErrorReport& report);
/// A page that needs nothing else: tables, the map, errors over time and their distribution.
std::string html_of(const ErrorReport& report, const std::string& title);

}  // namespace roomfix
