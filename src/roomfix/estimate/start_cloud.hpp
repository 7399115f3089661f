// Where a robot may be, from what its receivers and its detector say one after the other while it drives: where tracking starts.
#pragma once

#include <Eigen/Core>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "roomfix/base/random.hpp"
#include "roomfix/estimate/event.hpp"
#include "roomfix/estimate/tracking_models.hpp"

namespace roomfix {

/// What a robot heard or detected.
using Heard = std::variant<RangeObservation, RangeDifferenceObservation, SightingObservation>;

Nanoseconds time_of(const Heard& heard);

struct StartPlaces {
    std::vector<PlaceProposal> places;  // at the time of the newest that was heard; the likeliest first, weights add up to 1
    double error = 0;                   // m: standard deviation of what was heard there
    bool depth = false;                 // ranges seem to be depths (range_stretch.hpp)
    std::string reason;                 // why there are none
};

/// All around what may have been heard: each place from which it can have been heard, with the front that it then has, or all fronts if that does not tell it.
/// How the place and the front go together is in the covariance. `depth`: are ranges depths? None where no range was heard or seen.
std::vector<PlaceProposal> places_around(const Heard& heard, bool depth, const TrackingModels& models);

/// A place known less than that spoils every linearisation, m; `distance`: m, to what is heard.
double widest_place(double distance);
constexpr double widest_front = 0.3;  // rad, likewise

/// A particle filter over a place, a front, and how large the errors are: nothing that is stated of them is believed. It starts around the first thing that was
/// heard, moves as the wheels say (or at random where there are none), and is weighed by each thing that was heard. Errors of one source are alike where the
/// robot stands still, so what says nothing new is left out.
class StartCloud {
public:
    StartCloud() = default;
    /// `wheels`: what is known of how the wheels err for good. `depth`: are ranges depths?
    StartCloud(const WheelErrors& wheels, bool depth, std::uint64_t seed = 1) : wheels_(wheels), depth_(depth), random_(seed) {}
    bool empty() const { return guesses_.empty(); }
    /// In the order of times.
    void take(const Heard& heard, int robot, const TrackingModels& models);
    /// Where the robot may be by now, if that is clear enough to follow it from there: one place, or after `patience` (s) several, or one with an unknown
    /// front.
    StartPlaces places(double patience) const;

    /// Remembers where each guess is, for `marked`.
    void mark();
    /// Where the robot was when it was marked, by all that was heard since, the likeliest first.
    std::vector<PlaceProposal> marked() const;

private:
    struct Guess {
        double x = 0, y = 0, yaw = 0;  // m, rad
        double log_error = 0;          // of m
        double log_weight = 0;
        Pose2 marked;
        double scale = 0, turn_scale = 0;  // of the wheels, beyond what is known
        bool depth = false;                // ranges are depths
    };
    /// Where the robot was when a source was last heard.
    struct LastWord {
        double way = 0, turning = 0;
        Nanoseconds time = 0;
    };
    void begin(const Heard& heard, const TrackingModels& models);
    void guess_errors();
    void look(int robot, const Heard& heard, const TrackingModels& models);
    void move(Nanoseconds time, const TrackingModels& models);
    bool tells_something(const Heard& heard);
    void weigh(const Heard& heard, const TrackingModels& models);
    void draw_again();
    double turned_apart(double error) const;

    WheelErrors wheels_;
    std::optional<bool> depth_;
    std::vector<Guess> guesses_;
    int robot_ = 0;
    Nanoseconds begun_ = 0, time_ = 0;
    double way_ = 0, turning_ = 0;  // m, rad: driven since it began
    double distance_ = 1;           // m, to what was heard, smoothed
    bool shows_front_ = false;      // what was heard depends on where the front is
    bool front_by_way_ = false;     // but only by the way that was driven
    bool sees_ = false;             // there are bearings
    int used_ = 0;
    Random random_{1};
    std::map<std::pair<int, int>, LastWord> last_;  // of each receiver and beacon, or landmark
};

}  // namespace roomfix
