// The clock of somebody who sends us readings, against ours.
#pragma once

#include <string>

#include "roomfix/connect/stream_clock.hpp"

namespace roomfix {

/// Readings arrive after they were taken, mostly soon. If the least delay lately is a small one, the clocks agree and the sender's stamps are right; if it is
/// long or negative, the clocks differ by it, and stamps are moved by it: they are then late by the least delay, which nobody can know. Readings that queue up
/// somewhere come later and later, with stamps in their order: that is no clock that somebody set, unless it stays so for a minute.
class SenderClock {
public:
    /// The time of our clock at which a reading was taken. `stamp`: of the sender's clock; `arrival`: of ours; `steady`: s of a clock that only goes forward.
    Nanoseconds ours(Nanoseconds stamp, Nanoseconds arrival, double steady);
    /// How the clocks differ, in words; empty before the first reading.
    std::string told() const;

private:
    bool agrees() const;
    bool queued(double stamp, double offset, double steady);

    LeastOffset offset_;        // our clock minus the sender's
    double least_ = 0;          // s, now
    double last_stamp_ = 0;     // s, of the sender's clock
    double queued_since_ = -1;  // s, steady: since then all came much later than they were taken; negative: not so
};

}  // namespace roomfix
