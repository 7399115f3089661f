// Landmarks as a robot's own detector sees them: range and bearing, or either alone, with or without a name.
#pragma once

#include <vector>

#include "roomfix/estimate/sense_noise.hpp"
#include "roomfix/estimate/update.hpp"
#include "roomfix/observation/sighting_observation.hpp"

namespace roomfix {

/// A landmark as detectors see it.
struct Mark {
    Eigen::Vector2d place = Eigen::Vector2d::Zero();  // m, map
    double sigma = 0.002;                             // m, of each coordinate
    bool plain = true;                                // a mere point: what is seen without a name may be it
};

constexpr int of_detector = 1000;  // as the source of a slow state, in place of a receiver's number

/// How one robot's detector errs. Zero: there is no such error.
struct DetectorSource {
    Eigen::Vector2d position = Eigen::Vector2d::Zero(), position_sigma = Eigen::Vector2d::Zero();  // m, on the robot
    double range_factor = 1, bearing_factor = 1;                                                   // times the stated sigmas
    double range_common = 0, bearing_common = 0;                                                   // m, rad: what all sightings have in common
    double range_own = 0;                                                                          // m: what those of one landmark have in common
    double range_wander = 0;                  // m: what those of one landmark have in common and what changes with the place
    double range_sway = 0, bearing_sway = 0;  // m, rad: what all have in common and what changes with the place
    double bearing_shape = 0;                 // rad: what depends on the bearing itself
    StretchErrors stretch;                    // parts of the range
    double wander_way = 1;                    // m: over that way what depends on the place is another
    double bias_memory = 600;                 // s: over that time the rest changes
    LateModel late{.share = 0.02};            // of ranges that are far too long or short
    double misread = 0.02;                    // part of the names that are wrong
};
DetectorSource learned(DetectorSource source, const SenseNoise& noise);

/// Range (m), bearing (rad) and their derivatives by x, y, yaw. The range is positive.
struct PredictedSighting {
    double range = 0, bearing = 0;
    Eigen::Vector3d range_by_pose = Eigen::Vector3d::Zero(), bearing_by_pose = Eigen::Vector3d::Zero();
};
/// `detector`: m, its place on the robot.
PredictedSighting predict_sighting(const Pose2& pose, const Eigen::Vector2d& detector, const Eigen::Vector2d& mark);

/// Prepares the slow states of a landmark's sightings.
void add_slow_states(Belief& belief, const SightingObservation& seen, int landmark, const DetectorSource& source);

/// Range and bearing of a landmark that is taken for `landmark`; a part that was not seen has a residual of 0 and the noise `unseen`. An error without a slow
/// state is taken for noise.
constexpr double unseen = 1e6;
Linearised<2> linearise_sighting(const Belief& belief, const SightingObservation& seen, int landmark, const Mark& mark, const DetectorSource& source);

/// Weight of each landmark to be the one that was seen, before anything is known of the place: by the name, or all plain ones alike. 0: it cannot be.
double prior_of(const SightingObservation& seen, int landmark, const std::vector<Mark>& marks, const DetectorSource& source);

/// The landmark that was most likely seen; nothing where an outlier is likelier.
std::optional<int> likeliest_mark(const Belief& belief, const SightingObservation& seen, const std::vector<Mark>& marks, const DetectorSource& source,
                                  double outliers);

/// Takes a sighting into the belief. Where several landmarks may be the one, the likeliest is taken with the probability that it is (as in probabilistic data
/// association). `outliers`: part of the sightings that are no landmark at all. Nothing where there is no landmark.
std::optional<Innovation> update_sighting(Belief& belief, const SightingObservation& seen, const std::vector<Mark>& marks, const DetectorSource& source,
                                          double outliers);

}  // namespace roomfix
