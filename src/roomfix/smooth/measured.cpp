#include "roomfix/smooth/measured.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace roomfix {
namespace {

constexpr double place_doubt = 0.1;       // m, of a trajectory that is still to be smoothed
constexpr double yaw_doubt = 0.05;        // rad, likewise
constexpr double most_distance = 25;      // squared, between a look-alike's sighting and its trajectory
constexpr double same_wall_angle = 0.01;  // rad

Belief belief_on(const Trajectory& trajectory, Nanoseconds time) {
    Belief belief;
    belief.mean.setZero();
    belief.mean.head<6>() = trajectory.at(time);
    belief.covariance.topLeftCorner<core_states, core_states>().setZero();
    return belief;
}

double squared_distance(const PoseObservation& o, const std::optional<Trajectory>& trajectory, Nanoseconds time) {
    if (!trajectory || !trajectory->covers(time)) return std::numeric_limits<double>::infinity();
    const Eigen::Matrix2d spread = o.covariance.topLeftCorner<2, 2>() + place_doubt * place_doubt * Eigen::Matrix2d::Identity();
    const Eigen::Vector2d way = Eigen::Vector2d(o.pose.x, o.pose.y) - trajectory->at(time).head<2>();
    return way.dot(spread.inverse() * way);
}

/// The sighting that is this robot and no other of its group.
const PoseObservation* sighting_of(int robot, const GroupSighting& frame, const Group& group, Nanoseconds time,
                                   const std::vector<std::optional<Trajectory>>& trajectories) {
    const PoseObservation* best = nullptr;
    double least = most_distance;
    for (const PoseObservation& o : frame.robots) {
        const double own = squared_distance(o, trajectories[static_cast<std::size_t>(robot)], time);
        const bool of_another = std::any_of(group.robots.begin(), group.robots.end(), [&](int other) {
            return other != robot && squared_distance(o, trajectories[static_cast<std::size_t>(other)], time) < own;
        });
        if (of_another || own >= least) continue;
        least = own;
        best = &o;
    }
    return best;
}

template <int Points>
double misfit(Belief belief, const LandmarkObservation& seen, const KnownLandmark& landmark, const OnboardSource& source) {
    add_slow_states(belief, landmark, source, seen.time_error);
    const auto l = linearise_points<Points>(belief, seen, landmark, source);
    return l ? l->residual.squaredNorm() : std::numeric_limits<double>::infinity();
}

void add_landmarks(const LandmarkSighting& sighting, const Event& event, const Trajectory& trajectory, const TrackingModels& models,
                   std::vector<Measured>& measured) {
    const OnboardSource& source = models.onboard.at(event.source);
    const Belief belief = belief_on(trajectory, event.time);
    for (const LandmarkObservation& seen : sighting.landmarks) {
        double least = std::numeric_limits<double>::infinity();
        int best = -1;
        for (const int shape : seen.shapes) {
            for (const int landmark : models.shapes[static_cast<std::size_t>(shape)].landmarks) {
                const KnownLandmark known = models.landmark(landmark);
                const double far = seen.points.size() == 3 ? misfit<3>(belief, seen, known, source) : misfit<4>(belief, seen, known, source);
                if (far >= least) continue;
                least = far;
                best = landmark;
            }
        }
        if (best >= 0) measured.push_back({event.time, event.source, SeenLandmark{seen, best}});
    }
}

void add_corner(const CornerSighting& sighting, const Event& event, const Trajectory& trajectory, const TrackingModels& models,
                std::vector<Measured>& measured) {
    const OnboardSource& source = models.onboard.at(event.source);
    Belief belief = belief_on(trajectory, event.time);
    std::optional<SeenCorner> best;
    double least = std::numeric_limits<double>::infinity();
    for (const CornerObservation& seen : sighting.corners) {
        for (std::size_t k = 0; k < models.site.corners.size(); ++k) {
            const SiteCorner& corner = models.site.corners[k];
            if (std::abs(corner.wall_angle - seen.wall_angle) > same_wall_angle) continue;
            const double distance = corner.position.z() - source.camera.robot_from_camera.pose.translation().z();
            if (!(distance > corner.moulding.value_or(0))) continue;
            for (const CornerReading& reading : readings_of(seen, corner.moulding, distance)) {
                const auto l = linearise_corner(belief, reading.seen, corner, static_cast<int>(k), source);
                const double far = l ? l->residual.dot(l->noise.ldlt().solve(l->residual)) : std::numeric_limits<double>::infinity();
                if (far >= least) continue;
                least = far;
                best = SeenCorner{reading.seen, static_cast<int>(k)};
            }
        }
    }
    if (best) measured.push_back({event.time, event.source, *best});
}

/// The landmark that a detector saw, as seen from the trajectory; what fits none is left out.
void add_mark(const SightingObservation& seen, const Event& event, const Trajectory& trajectory, const TrackingModels& models, int robot,
              const KnownErrors& known, std::vector<Measured>& measured) {
    Belief belief = belief_on(trajectory, event.time);
    belief.covariance(state_x, state_x) = belief.covariance(state_y, state_y) = place_doubt * place_doubt;
    belief.covariance(state_yaw, state_yaw) = yaw_doubt * yaw_doubt;
    if (known) known(belief, event.time);
    if (const auto landmark = likeliest_mark(belief, seen, models.marks, models.detectors[static_cast<std::size_t>(robot)], models.settings.outliers)) {
        measured.push_back({event.time, event.source, SeenMark{seen, *landmark}});
    }
}

}  // namespace

int thing_of(const Measured& measured) {
    if (const auto* landmark = std::get_if<SeenLandmark>(&measured.what)) return landmark->landmark;
    if (const auto* corner = std::get_if<SeenCorner>(&measured.what)) return corner->corner;
    if (const auto* mark = std::get_if<SeenMark>(&measured.what)) return mark->landmark;
    if (const auto* range = std::get_if<RangeObservation>(&measured.what)) return range->beacon;
    return 0;
}

std::vector<Measured> measured_of(int robot, const TrackerHistory& history, const std::vector<Group>& groups, const TrackingModels& models,
                                  const std::vector<std::optional<Trajectory>>& trajectories, const KnownErrors& known) {
    std::vector<Measured> measured;
    const auto& trajectory = trajectories[static_cast<std::size_t>(robot)];
    if (!trajectory) return measured;
    for (const auto& [group_number, event] : history.events) {
        const Group& group = groups[group_number];
        const bool of_group = std::find(group.robots.begin(), group.robots.end(), robot) != group.robots.end();
        const int about = robot_of(event);
        if (!of_group || (about >= 0 && about != robot) || !trajectory->covers(event.time)) continue;
        if (const auto* frame = std::get_if<GroupSighting>(&event.what)) {
            const PoseObservation* seen = sighting_of(robot, *frame, group, event.time, trajectories);
            if (seen != nullptr) measured.push_back({event.time, event.source, *seen});
        } else if (const auto* pose = std::get_if<PoseObservation>(&event.what)) {
            measured.push_back({event.time, event.source, *pose});
        } else if (const auto* tag = std::get_if<TagSighting>(&event.what)) {
            measured.push_back({event.time, event.source, *tag});
        } else if (const auto* range = std::get_if<RangeObservation>(&event.what)) {
            measured.push_back({event.time, event.source, *range});
        } else if (const auto* difference = std::get_if<RangeDifferenceObservation>(&event.what)) {
            measured.push_back({event.time, event.source, *difference});
        } else if (const auto* landmarks = std::get_if<LandmarkSighting>(&event.what)) {
            add_landmarks(*landmarks, event, *trajectory, models, measured);
        } else if (const auto* mark = std::get_if<SightingObservation>(&event.what)) {
            add_mark(*mark, event, *trajectory, models, robot, known, measured);
        } else if (const auto* corners = std::get_if<CornerSighting>(&event.what)) {
            add_corner(*corners, event, *trajectory, models, measured);
        }
    }
    std::stable_sort(measured.begin(), measured.end(), [](const Measured& a, const Measured& b) { return a.time < b.time; });
    return measured;
}

}  // namespace roomfix
