#include "roomfix/connect/sender_clock.hpp"

#include <fmt/format.h>

#include <cmath>

namespace roomfix {
namespace {

constexpr double earliest = -0.002;   // s: a reading that comes sooner than this after it was taken shows that the clocks differ
constexpr double most_offset = 4e9;   // s: more cannot be told in nanoseconds beside the time of our clock
constexpr double long_delay = 0.04;   // s more than the least: the reading was held up, or a clock was set
constexpr double out_of_order = 1;    // s: stamps that go back so far are of a clock that was set
constexpr double longest_queue = 60;  // s
constexpr double latest = 0.05;       // s: within a building, nothing that is sent at once takes longer at its fastest

}  // namespace

bool SenderClock::agrees() const { return least_ >= earliest && least_ <= latest; }

/// Did the reading only wait somewhere?
bool SenderClock::queued(double stamp, double offset, double steady) {
    const bool in_order = stamp > last_stamp_ - out_of_order;
    last_stamp_ = stamp;
    if (offset_.empty() || !in_order || offset < offset_.at(steady) + long_delay) {
        queued_since_ = -1;
        return false;
    }
    if (queued_since_ < 0) queued_since_ = steady;
    return steady - queued_since_ < longest_queue;
}

Nanoseconds SenderClock::ours(Nanoseconds stamp, Nanoseconds arrival, double steady) {
    const double offset = to_seconds(arrival) - to_seconds(stamp);
    if (std::abs(offset) > most_offset) return arrival;
    if (!queued(to_seconds(stamp), offset, steady)) offset_.add(steady, offset);
    least_ = offset_.at(steady);
    return agrees() ? stamp : stamp + from_seconds(least_);
}

std::string SenderClock::told() const {
    if (offset_.empty()) return "";
    const double drift = 1e6 * offset_.drift();
    if (agrees())
        return fmt::format("its clock agrees with ours; readings take {:.1f} ms to come, and {:.1f} ms more at times", 1e3 * least_, 1e3 * offset_.jitter());
    return fmt::format("its clock is {:.3f} s {} ours and drifts by {:.0f} ppm: its times are moved by that; let both follow NTP", std::abs(least_),
                       least_ > 0 ? "behind" : "ahead of", drift);
}

}  // namespace roomfix
