// Ranges as an ultrasonic listener gives them.
#pragma once

#include <optional>
#include <string>

#include "roomfix/base/random.hpp"

namespace roomfix {

struct RangeModel {
    double sigma = 0.015;          // m
    double late_share = 0;         // of ranges that come around a corner ...
    double late_mean = 0.4;        // m, ... later by an exponential delay of this mean
    double lost = 0.05;            // part of the messages that is never heard
    double temperature = 20;       // degC, as the site file says
    double temperature_error = 0;  // degC, what the air really is above that
};

/// What the listener says of one message.
struct HeardMessage {
    double flight_time = 0;  // s, to the microsecond
    double distance = 0;     // m, to the centimetre, with the listener's own fixed speed of sound
};

/// Nothing if the message is lost. `distance` is the true one, m.
std::optional<HeardMessage> hear(const RangeModel& model, double distance, Random& random);

/// The Cricket v2 line for a message.
std::string cricket_line(const std::string& space, const HeardMessage& message, long clock_ms);

}  // namespace roomfix
