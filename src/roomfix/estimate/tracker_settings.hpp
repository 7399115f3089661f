// What the tracker takes for granted.
#pragma once

#include "roomfix/base/time.hpp"
#include "roomfix/estimate/motion.hpp"
#include "roomfix/estimate/odometry_track.hpp"
#include "roomfix/observation/range_noise.hpp"

namespace roomfix {

struct TrackerSettings {
    Nanoseconds lag = 1'000'000'000;  // how late an observation may come
    MotionModel motion;               // of robots without a stated drive
    OdometryNoise odometry;
    OdometryLimits odometry_limits;
    LateModel late;
    double unknown_wheels = 3;       // times the wheels' random errors, of a robot that was found by its own senses, until it is learned how they err
    double range_bias_memory = 600;  // s
    double wander_way = 1;           // m: over that way an error that depends on the place is another

    double receiver_place = 0.02;  // m, along each axis: how well the places of several receivers on one robot are known where nothing is stated, since aerials
                                   // measure from a point that nobody sees; their heading hangs on it

    double body_memory = 2;  // s: over that time what a robot's description leaves out moves its place elsewhere, as it drives and turns

    bool learns = true;  // how the robots' own senses err

    double outliers = 0.01;    // share of observations that are wrong altogether
    double gate = 9;           // squared Mahalanobis distance, beyond twice the mean of a right one, at which right and wrong are equally likely
    double area = 100;         // m^2: over it wrong poses are spread
    double conviction = 10;    // nats per second: how fast evidence may turn the balance between hypotheses, and who is who
    double kidnapping = 1e-3;  // weight of a new place that contradicts the old
    double surprise = 0.02;    // probability that a robot is not where it should be, before anybody looks
    double hidden_for = 0.5;   // s: what hides a robot that is there goes on to do so for about as long
    double backwards = 5;      // nats per metre: how unlikely robots drive backwards where their front is unknown

    double start_patience = 30;  // s: after so long a robot that only hears and detects starts though its front or its place is not sure
    double start_speed = 0.7;    // m/s (1 sigma)
    double start_turning = 1.0;  // rad/s (1 sigma)
    double ok = 0.35;            // s without an absolute observation until a fix is coasting
    double anywhere = 3;         // m (1 sigma): a place known less counts for nothing, the next sighting starts the track anew
    double naming = 2;  // s from the first sighting for which a robot is no fix while its name may as well be another's, though its wheels or a tag will tell
    double sure_of_name = 0.97;  // probability of a name that may as well not be another's
    double confirmations = 2;    // observations before one of several look-alikes is reported at a new place
    double forget = 5;           // s until a lost look-alike is dropped
    double like_gate = 16;       // squared distance beyond which a sighting is another of the look-alikes

    double quarantine_below = 0.3;  // mean probability of being right: a source below is no longer believed ...
    double readmit_above = 0.7;     // ... until it is above this again
    int quarantine_after = 5;       // observations at least
};

}  // namespace roomfix
