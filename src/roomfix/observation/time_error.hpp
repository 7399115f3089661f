// How far the time of a camera's frame may be off.
#pragma once

namespace roomfix {

/// As far as the source of the frames knows it, beside what the site states. All frames whose times were told in one way err alike: by the camera's own clock,
/// say, or by when they arrived over one connection.
struct TimeError {
    double sigma = 0;  // s
    int way = 0;

    bool operator==(const TimeError&) const = default;
};

}  // namespace roomfix
