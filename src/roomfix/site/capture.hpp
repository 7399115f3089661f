// How a live camera is to take its pictures, and how late they come.
#pragma once

#include <optional>

namespace roomfix {

struct CaptureSettings {
    std::optional<double> rate;           // pictures per second
    std::optional<double> exposure;       // s
    std::optional<double> gain;           // in the camera's own unit
    std::optional<double> white_balance;  // K
    double readout = 0;                   // s from when the first row is exposed until the last one is; 0: all at once
    std::optional<double> delay;          // s from the middle of a picture's exposure to its arrival, where the camera does not tell the time
};

}  // namespace roomfix
