// What the reports of a stream's sender say of its wall clock, one beside the other.
#pragma once

#include <deque>

#include "roomfix/base/time.hpp"

namespace roomfix {

/// A sender tells every few seconds what its wall clock and its media clock show at one moment; until the next report, all wall times hang on that one. A busy
/// sender is held up between reading the two, and is then off by tens of milliseconds. The line through the reports of the last half minute is not moved by one
/// of them; what they are off from it is how far the sender's times are to be trusted.
class SenderReports {
public:
    /// The wall time of a picture by all reports of late. `media`: s of the media clock; `wall`: by the last report alone.
    Nanoseconds corrected(double media, Nanoseconds wall);
    /// How far the reports were off from their line, s, mean of the last half minute.
    double spread() const { return spread_; }
    /// How far the last one is off from it, s: either it is wrong, or the clock was set anew.
    double last_off() const { return last_off_; }
    void clear() { *this = {}; }

private:
    struct Point {
        double media = 0, offset = 0;  // s since the first picture: media clock, wall clock minus media clock
    };
    void fit();

    std::deque<Point> points_;  // one for each second
    Nanoseconds first_wall_ = 0;
    double first_media_ = 0;
    double from_ = 0, level_ = 0, slope_ = 0;  // the line, s and s/s
    double spread_ = 0, last_off_ = 0;
};

}  // namespace roomfix
