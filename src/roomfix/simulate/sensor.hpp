// What lens and sensor make of the light: blur, glare, vignetting, gamma, mains hum, noise, 8 bits. Pictures of light are row by row.
#pragma once

#include <cstdint>
#include <vector>

#include "roomfix/imaging/luma.hpp"

namespace roomfix {

/// What the sensor and its optics do to the light.
struct SensorModel {
    double blur = 0.7;       // px, standard deviation of the point spread
    double exposure = 0.75;  // grey level (of 1) of light 1, before gamma
    double gamma = 2.2;
    double vignetting = 0.25;  // light lost at the corner
    double read_noise = 1.2;   // grey levels
    double shot_noise = 0.12;  // grey levels^2 per grey level
    double flicker = 0.01;     // relative; mains hum across the rows of a rolling shutter
};

/// Light that the lens and the sensor's cover scatter around everything bright.
struct GlareModel {
    double part = 0.04;  // of the light ...
    double reach = 9;    // px, ... over about this radius
};

/// Part of the noise-free picture's change that a pixel's noise leaves: sqrt of the variance of one pixel, grey levels.
double pixel_noise(const SensorModel& sensor, double grey);

/// Lens and sensor of one camera.
class Sensor {
public:
    Sensor(int width, int height, const SensorModel& model, const GlareModel& glare, std::uint64_t seed);

    const SensorModel& model() const { return model_; }
    /// The lens: a Gaussian of the sensor's blur.
    void blur(std::vector<float>& light);
    void add_glare(std::vector<float>& light);
    /// Light to grey levels without noise and rounding; above 255 where the sensor saturates.
    void expose(std::vector<float>& light, double gain) const;
    /// The frame with its noise: the same `index` gives the same bytes.
    void take(const std::vector<float>& exposed, std::uint64_t index, LumaImage& frame) const;

private:
    int width_, height_;
    SensorModel model_;
    GlareModel glare_;
    std::uint64_t seed_;
    std::vector<float> work_;
    std::vector<float> glow_;
};

}  // namespace roomfix
