// Everything that the tracker can be told, as one kind of value that can wait in a buffer.
#pragma once

#include <tuple>
#include <variant>
#include <vector>

#include "roomfix/base/time.hpp"
#include "roomfix/observation/absence.hpp"
#include "roomfix/observation/corner_observation.hpp"
#include "roomfix/observation/landmark_observation.hpp"
#include "roomfix/observation/pose_observation.hpp"
#include "roomfix/observation/range_observation.hpp"
#include "roomfix/observation/sighting_observation.hpp"
#include "roomfix/observation/time_error.hpp"

namespace roomfix {

/// A place where a robot may be, found from the same observation or from several at once: where tracking may start.
struct PlaceProposal {
    Pose2 pose;
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();
    bool yaw_known = true;
    double weight = 1;
    double late = 0;        // s: how much later than the frame's time it was seen there, as of a PoseObservation
    double time_sigma = 0;  // s, of the frame's time
};

/// All robots of a group of look-alikes in one frame of a fixed camera.
struct GroupSighting {
    std::vector<PoseObservation> robots;
};

struct LandmarkSighting {
    int robot = 0;
    std::vector<LandmarkObservation> landmarks;
    std::vector<PlaceProposal> proposals;
};

/// The tag on a robot in a frame of a fixed camera.
struct TagSighting {
    int robot = 0;
    FixedList<PointSighting, 4> corners;  // bottom left, bottom right, top right, top left, as the tag is read
    std::vector<PlaceProposal> proposals;
    TimeError time_error;
};

struct CornerSighting {
    int robot = 0;
    std::vector<CornerObservation> corners;
    std::vector<PlaceProposal> proposals;
};

/// Places found from several observations together; they only say where tracking may start, they are not fused.
struct PlaceSighting {
    int robot = 0;
    std::vector<PlaceProposal> proposals;
};

/// Nothing but that time has passed: keeps the state of a robot near the present while only its wheels speak.
struct TimePassed {
    int robot = 0;
};

struct Event {
    Nanoseconds time = 0;
    int source = 0;  // of the tracker's sources
    int key = 0;     // tells apart what one source says at one time
    std::variant<PoseObservation, GroupSighting, TagSighting, LandmarkSighting, CornerSighting, RangeObservation, RangeDifferenceObservation,
                 SightingObservation, PlaceSighting, AbsenceObservation, TimePassed>
        what;

    bool operator<(const Event& other) const { return std::tie(time, source, key) < std::tie(other.time, other.source, other.key); }
};

/// The robot that an event is about; -1: a frame that may show any of its group.
int robot_of(const Event& event);

}  // namespace roomfix
