// One smooth pose per robot from what cameras and ranges say of it: a constant-velocity Kalman filter for each.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "roomfix/observation/fix.hpp"
#include "roomfix/observation/pose_observation.hpp"
#include "roomfix/site/site.hpp"

namespace roomfix {

struct SmootherSettings {
    double acceleration = 0.8;  // m/s^2, what robots do between two frames (1 sigma)
    double turning = 1.0;       // rad/s (1 sigma)
    double gate = 16;           // squared Mahalanobis distance in x, y beyond which an observation is another robot
    double coast = 1.0;         // s without observation until a robot is lost, at most as long as it was seen before
    double forget = 5;          // s until its track is dropped
    int confirmations = 2;      // observations before a robot is reported at a new place
    double ok = 0.35;           // s without observation until a fix is coasting
};

/// Names: a robot of which the site has one keeps its id; of many, "ID-1", "ID-2", ... in the order they appear.
class Smoother {
public:
    Smoother(std::vector<SiteRobot> robots, const SmootherSettings& settings = {});

    /// Takes the observations of one frame of one camera. Frames must come in order of time, up to `coast` late; older ones
    /// are counted in `late()` and not used.
    void add(Nanoseconds time, const std::string& camera, const std::vector<PoseObservation>& observations);

    /// Where a robot is expected at a time, if it is tracked and not lost.
    std::optional<PoseObservation> expected(int robot, Nanoseconds time) const;

    /// All robots at a time not before the last observation: ok, coasting, or left out when lost.
    std::vector<Fix> fixes(Nanoseconds time) const;
    long late() const { return late_; }

private:
    struct Track {
        int robot;
        std::string name;
        Nanoseconds time = 0;  // of the state
        Nanoseconds born = 0;  // first observation
        Nanoseconds seen = 0;  // last observation
        int sightings = 0;
        double spread = 1;                                // m^2, variance of the place when it was last seen
        double presence = 1;                              // part of the last frames of its cameras that showed it
        Eigen::Vector4d state = Eigen::Vector4d::Zero();  // x, y, vx, vy
        Eigen::Matrix4d covariance = Eigen::Matrix4d::Identity();
        double yaw = 0;
        double yaw_variance = 1;
        bool yaw_known = false;
        std::vector<std::pair<std::string, Nanoseconds>> sources;
    };
    void predict(Track& track, Nanoseconds time) const;
    double distance(const Track& track, const PoseObservation& observation) const;
    void update(Track& track, Nanoseconds time, const std::string& camera, const PoseObservation& observation) const;
    double patience(const Track& track) const;
    double patience_with(const Track& old, const Track& fresh) const;
    void drop_doubles();
    void confirm(Nanoseconds time);
    void start(Nanoseconds time, const std::string& camera, const PoseObservation& observation);

    std::vector<SiteRobot> robots_;
    SmootherSettings settings_;
    std::vector<Track> tracks_;
    std::vector<int> names_given_;
    long late_ = 0;
};

}  // namespace roomfix
