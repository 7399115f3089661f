// When the pictures of a network stream were taken: by the sender's wall clock where it tells it, else by their arrival less what made them late.
#pragma once

#include <deque>
#include <optional>
#include <string>

#include "roomfix/base/time.hpp"
#include "roomfix/connect/sender_reports.hpp"
#include "roomfix/observation/time_error.hpp"

namespace roomfix {

/// A picture that has come.
struct FrameArrival {
    Nanoseconds system = 0;           // of our clock
    double steady = 0;                // s of a clock that only goes forward, at the same moment
    std::optional<double> media;      // s of the sender's media clock: runs evenly, starts anywhere
    std::optional<Nanoseconds> wall;  // of the sender's wall clock: when it took the picture, as it says
};

struct StampedTime {
    Nanoseconds time = 0;  // of our clock
    TimeError error;
};

/// The least of (our clock minus another clock) as it changes: the straight line below all points of the last minute that lies closest to them. Its slope is
/// the drift of one clock against the other, what lies above it is delay that comes and goes.
class LeastOffset {
public:
    /// Takes a point in; times rise. s.
    void add(double time, double offset);
    /// The line at a time, s; as a constant while the stretch is too short to tell a drift.
    double at(double time) const;
    /// Mean of what points lay above the line lately, s.
    double jitter() const { return jitter_; }
    double drift() const { return slope_; }
    bool empty() const { return lowest_.empty(); }
    void clear() { *this = {}; }

private:
    struct Point {
        double time = 0, offset = 0;
    };
    void fit();

    std::deque<Point> lowest_;  // the least of each second
    double level_ = 0, slope_ = 0, from_ = 0;
    double jitter_ = 0;
};

/// One camera's clock. It outlives connections: what was learned of the delay serves the first pictures of the next one.
class StreamClock {
public:
    /// `delay`: s from a picture's exposure to its arrival, as the site states it.
    explicit StreamClock(std::optional<double> delay = std::nullopt) : stated_delay_(delay) {}
    /// The time of a picture, in the order in which they come; later than that of the picture before, unless the media clock says otherwise.
    StampedTime stamp(FrameArrival arrival);
    /// A new connection: the media clock starts anew.
    void restart();
    /// Where the times come from and how exact they are, in words.
    std::string told() const;

private:
    enum class Wall { none, usable, ahead, behind };
    StampedTime by_wall(const FrameArrival& arrival) const;
    StampedTime by_arrival(const FrameArrival& arrival) const;
    double wall_sigma() const;  // s, where the reports agree
    void correct_wall(FrameArrival& arrival);
    void judge_wall(const FrameArrival& arrival);
    void follow_media(const FrameArrival& arrival);
    void note_intervals(const FrameArrival& arrival);

    std::optional<double> stated_delay_;
    std::optional<double> learned_delay_;  // s, least, by the sender's wall clock
    LeastOffset media_;                    // our steady clock minus the media clock
    LeastOffset wall_;                     // our clock minus the sender's wall clock
    SenderReports reports_;
    int contradiction_ = 0;  // way of telling times while the last report contradicts those before; 0: it does not
    Wall wall_state_ = Wall::none;
    bool has_media_ = false;
    std::optional<double> last_media_;  // s, of the picture before
    double last_steady_ = 0;            // s, of the picture before
    double last_interval_ = 0;          // s
    double unevenness_ = 0;             // s, of the intervals between pictures
    int connection_ = 1;                // way of telling times by arrival
    int last_way_ = 1;
    int since_restart_ = 0;  // pictures
    StampedTime last_;
};

}  // namespace roomfix
