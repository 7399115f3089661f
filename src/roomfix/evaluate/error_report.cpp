#include "roomfix/evaluate/error_report.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "roomfix/base/decompositions.hpp"
#include "roomfix/evaluate/robot_point.hpp"

namespace roomfix {
namespace {

constexpr double independent_after = 2;  // s: errors of fixes that far apart count as independent
constexpr double relative_over = 1;      // s

std::string joined(std::vector<std::string> names) {
    std::sort(names.begin(), names.end());
    std::string text;
    for (const std::string& name : names) text += (text.empty() ? "" : "+") + name;
    return text.empty() ? "prediction" : text;
}

/// Collects normalised squares of one series of times.
class NormalisedSquares {
public:
    void add(Nanoseconds time, double square, int dimensions) {
        sum_ += square;
        dimensions_ += dimensions;
        if (!last_ || to_seconds(time - *last_) >= independent_after) {
            last_ = time;
            ++independent_;
            independent_dimensions_ += dimensions;
        }
    }
    void start_series() { last_.reset(); }
    Consistency result() const {
        Consistency c;
        if (dimensions_ == 0) return c;
        c.mean = sum_ / dimensions_;
        c.independent = independent_;
        const double spread = 1.96 * std::sqrt(2.0 / independent_dimensions_);
        c.low = std::max(0.0, 1 - spread);
        c.high = 1 + spread;
        return c;
    }

private:
    double sum_ = 0;
    double dimensions_ = 0, independent_dimensions_ = 0;
    std::size_t independent_ = 0;
    std::optional<Nanoseconds> last_;
};

ErrorTable table_of(const std::string& name, const std::vector<const JudgedFix*>& fixes) {
    ErrorTable table;
    table.name = name;
    std::vector<double> position, yaw;
    NormalisedSquares nees;
    std::string robot;
    double stated = 0, bounds = 0, bounded_squares = 0;
    int bounded = 0;
    for (const JudgedFix* f : fixes) {
        position.push_back(f->error.head<2>().norm());
        if (f->yaw_judged()) yaw.push_back(std::abs(f->error.z()));
        if (f->robot != robot) nees.start_series();
        robot = f->robot;
        nees.add(f->time, f->nees, f->dimensions);
        stated += f->covariance.topLeftCorner<2, 2>().trace();
        if (!f->bound) continue;
        ++bounded;
        bounds += *f->bound * *f->bound;
        bounded_squares += f->error.head<2>().squaredNorm();
    }
    table.position = summarise(position);
    table.yaw = summarise(yaw);
    table.nees = nees.result();
    table.stated_sigma = fixes.empty() ? 0 : std::sqrt(stated / static_cast<double>(fixes.size()));
    if (bounded > 0) {
        table.bound = std::sqrt(bounds / bounded);
        table.over_bound = std::sqrt(bounded_squares / bounds);
    }
    return table;
}

double place_distance(const Pose2& a, const Pose2& b) { return std::hypot(a.x - b.x, a.y - b.y); }

/// The true robot that a fix is about: its namesake, or the nearest of its kind.
std::string true_robot(const Fix& fix, const Truth& truth) {
    if (truth.contains(fix.robot)) return fix.robot;
    const std::size_t dash = fix.robot.rfind('-');
    const std::string kind = fix.robot.substr(0, dash);
    std::string nearest;
    double least = 1e300;
    for (const auto& [robot, poses] : truth) {
        if (dash == std::string::npos || robot.rfind(kind, 0) != 0) continue;
        const auto pose = pose_at(poses, fix.time);
        if (pose && place_distance(*pose, fix.pose) < least) {
            least = place_distance(*pose, fix.pose);
            nearest = robot;
        }
    }
    return nearest;
}

JudgedFix judged(const Fix& fix, const TruePose& truth, double symmetry) {
    JudgedFix j;
    j.time = fix.time;
    j.robot = fix.robot;
    j.sources = joined(fix.sources);
    j.coasting = fix.status == FixStatus::coasting;
    j.fix = fix.pose;
    j.truth = truth;
    j.fix_has_yaw = fix.yaw_known;
    j.truth_has_yaw = truth.yaw_known;
    j.covariance = fix.covariance;
    j.error = pose_error(fix.pose, truth, symmetry > 0 ? symmetry : 2 * std::numbers::pi);
    if (!j.yaw_judged()) j.error.z() = 0;
    const Eigen::Matrix2d place = fix.covariance.topLeftCorner<2, 2>();
    j.dimensions = j.yaw_judged() ? 3 : 2;
    j.nees = j.yaw_judged() ? nees(j.error, fix.covariance) : j.error.head<2>().dot(place.inverse() * j.error.head<2>());
    return j;
}

/// The way from one moment to the next, in the frame of the first or in that of the map.
Eigen::Vector3d way_between(const Pose2& from, const Pose2& to, bool own_frame) {
    const Eigen::Vector2d way = Eigen::Rotation2Dd(own_frame ? -from.yaw : 0) * Eigen::Vector2d(to.x - from.x, to.y - from.y);
    return {way.x(), way.y(), wrap_angle(to.yaw - from.yaw)};
}

void judge_ways(const std::map<std::string, std::vector<const JudgedFix*>>& by_robot, ErrorReport& report) {
    std::vector<double> position, yaw;
    for (const auto& [robot, fixes] : by_robot) {
        std::size_t later = 0;
        for (const JudgedFix* from : fixes) {
            while (later < fixes.size() && to_seconds(fixes[later]->time - from->time) < relative_over) ++later;
            if (later == fixes.size()) break;
            const JudgedFix* to = fixes[later];
            if (to_seconds(to->time - from->time) > 1.2 * relative_over) continue;
            const bool turned = from->yaw_judged() && to->yaw_judged();
            const Eigen::Vector3d off = way_between(from->fix, to->fix, turned) - way_between(from->truth, to->truth, turned);
            position.push_back(off.head<2>().norm());
            if (turned) yaw.push_back(std::abs(wrap_angle(off.z())));
        }
    }
    report.relative_position = summarise(position);
    report.relative_yaw = summarise(yaw);
}

/// Part of all true moments with a fix that is fresh, over robots with a name of their own.
double availability_of(const std::map<std::string, std::vector<const JudgedFix*>>& by_true_robot, const Truth& truth, double fresh) {
    std::size_t moments = 0, covered = 0;
    for (const auto& [robot, poses] : truth) {
        const auto found = by_true_robot.find(robot);
        std::size_t next = 0;
        for (const StampedPose& moment : poses) {
            ++moments;
            if (found == by_true_robot.end()) continue;
            const auto& fixes = found->second;
            while (next < fixes.size() && fixes[next]->time <= moment.time) ++next;
            covered += next > 0 && to_seconds(moment.time - fixes[next - 1]->time) <= fresh;
        }
    }
    return moments > 0 ? static_cast<double>(covered) / static_cast<double>(moments) : 0;
}

/// Names that were another robot's from the start, and names that move from one robot to another.
void count_switches(const std::vector<Fix>& fixes, const Truth& truth, double apart, ErrorReport& report) {
    std::map<std::string, std::string> follows;  // the robot that each name was on last
    std::map<std::string, Nanoseconds> doubtful;
    double squares = 0;
    int followed = 0;
    for (const Fix& fix : fixes) {
        if (fix.status == FixStatus::none) continue;
        if (fix.identity < 0.95) doubtful[fix.robot] = fix.time;
        std::string nearest;
        double least = apart;
        for (const auto& [robot, poses] : truth) {
            const auto pose = pose_at(poses, fix.time);
            if (pose && place_distance(*pose, fix.pose) < least) {
                least = place_distance(*pose, fix.pose);
                nearest = robot;
            }
        }
        if (nearest.empty()) continue;
        const bool own_name = truth.contains(fix.robot);
        if (own_name) {
            const auto own = pose_at(truth.at(fix.robot), fix.time);
            if (own && place_distance(*own, fix.pose) < apart) {  // still where it should be
                nearest = fix.robot;
                least = place_distance(*own, fix.pose);
            }
        }
        const auto [at, first] = follows.try_emplace(fix.robot, nearest);
        std::string& before = at->second;
        if (first && own_name && nearest != fix.robot) {
            ++report.misnamed;
            report.flagged_misnamed += fix.identity < 0.95;
        }
        squares += least * least;
        ++followed;
        if (nearest == before) continue;
        ++report.identity_switches;
        const auto doubt = doubtful.find(fix.robot);
        report.flagged_switches += doubt != doubtful.end() && to_seconds(fix.time - doubt->second) < 5;
        before = nearest;
    }
    if (followed > 0) report.followed_rms = std::sqrt(squares / followed);
}

/// Fixes of the point that the truth is about, one for each fix; status none where nobody knows where it is.
std::vector<Fix> fixes_of_point(const std::vector<Fix>& fixes, const Eigen::Vector2d& point, ErrorReport& report) {
    std::vector<Fix> there = fixes;
    for (Fix& fix : there) {
        if (fix.status == FixStatus::none) continue;
        if (const auto moved = fix_of_point(fix, point)) {
            fix = *moved;
        } else {
            fix.status = FixStatus::none;
            ++report.without_point[fix.robot];
        }
    }
    return there;
}

ConfidentlyWrong confidently_wrong(const std::vector<JudgedFix>& fixes) {
    ConfidentlyWrong result;
    std::vector<double> stated;
    for (const JudgedFix& f : fixes) {
        if (f.coasting) continue;
        ++result.fixes;
        if (f.error.head<2>().norm() > result.farther_than) stated.push_back(std::sqrt(f.covariance.topLeftCorner<2, 2>().trace()));
    }
    result.wrong = stated.size();
    result.stated_sigma = summarise(std::move(stated)).median;
    return result;
}

double place_sigma_of_point(const Eigen::Matrix3d& covariance, const Eigen::Vector2d& point, double yaw) {
    const Eigen::Matrix3d derivatives = point_from_middle(point, yaw);
    const Eigen::Matrix3d there = derivatives * covariance * derivatives.transpose();
    return std::sqrt(there.topLeftCorner<2, 2>().trace());
}

}  // namespace

ErrorReport judge(const RecordedFixes& recorded, const Truth& everything, const ReportOptions& options,
                  const std::vector<std::optional<Eigen::Matrix3d>>& bounds) {
    ErrorReport report;
    const Truth truth = robots_of(everything), things = unknown_things_of(everything);
    report.unknown_things = judge_things(recorded.unknown_things, things, times_of(everything), options.cutoff, options.fresh);
    std::set<std::string> unknown;
    std::vector<std::string> truly;
    std::map<std::string, NormalisedSquares> nis;
    std::size_t coasting = 0;
    std::vector<double> latencies;
    const std::vector<Fix> fixes_there = fixes_of_point(recorded.fixes, options.point, report);
    for (std::size_t number = 0; number < fixes_there.size(); ++number) {
        const Fix& fix = fixes_there[number];
        if (fix.status == FixStatus::none) continue;
        const std::string robot = true_robot(fix, truth);
        const auto pose = robot.empty() ? std::nullopt : pose_at(truth.at(robot), fix.time);
        if (robot.empty() || pose) {
            const bool away = !pose || place_distance(*pose, fix.pose) > options.apart;
            count_on_thing(recorded.fixes[number], away, things, options.on_thing, report.unknown_things);
        }
        if (robot.empty()) unknown.insert(fix.robot);
        if (!pose) continue;
        report.fixes.push_back(judged(fix, *pose, options.symmetry));
        report.without_true_yaw += fix.yaw_known && !pose->yaw_known;
        if (number < bounds.size() && bounds[number]) report.fixes.back().bound = place_sigma_of_point(*bounds[number], options.point, fix.pose.yaw);
        truly.push_back(robot);
        coasting += fix.status == FixStatus::coasting;
        if (fix.latency) latencies.push_back(*fix.latency);
        for (const InnovationSquare& square : fix.nis) nis[square.source].add(fix.time, square.nis, square.dimensions);
    }
    report.latency = summarise(latencies);
    report.unknown_robots.assign(unknown.begin(), unknown.end());
    report.coasting = report.fixes.empty() ? 0 : static_cast<double>(coasting) / static_cast<double>(report.fixes.size());

    std::vector<const JudgedFix*> all;
    std::map<std::string, std::vector<const JudgedFix*>> by_robot, by_true_robot, by_sources;
    for (std::size_t i = 0; i < report.fixes.size(); ++i) {
        const JudgedFix& f = report.fixes[i];
        by_robot[f.robot].push_back(&f);
        by_true_robot[truly[i]].push_back(&f);
        by_sources[f.coasting ? "prediction" : f.sources].push_back(&f);
    }
    for (const auto& [robot, fixes] : by_robot) all.insert(all.end(), fixes.begin(), fixes.end());
    report.all = table_of("all", all);
    for (const auto& [robot, fixes] : by_robot) report.robots.push_back(table_of(robot, fixes));
    for (const auto& [sources, fixes] : by_sources) report.sources.push_back(table_of(sources, fixes));
    for (const auto& [source, squares] : nis) report.nis.emplace_back(source, squares.result());
    judge_ways(by_robot, report);
    report.availability = availability_of(by_true_robot, truth, options.fresh);
    count_switches(fixes_there, truth, options.apart, report);
    report.confidently_wrong = confidently_wrong(report.fixes);
    const Moments moments = moments_of(fixes_there, truth, times_of(truth), options.cutoff, options.fresh);
    report.gospa = gospa_of(moments);
    report.identities = identity_score(moments);
    report.hota = hota_of(moments);
    return report;
}

}  // namespace roomfix
