// What lens and sensor make of the light: blur, glare, vignetting, gamma, mains hum, noise, 8 bits. Pictures of light are row by row.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
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
    double readout = 0;        // s from when the first row is exposed until the last one is; the picture's time is that of the middle row
};

/// Light that the lens and the sensor's cover scatter around everything bright.
struct GlareModel {
    double part = 0.04;  // of the light ...
    double reach = 9;    // px, ... over about this radius
};

/// sqrt of the variance of one pixel, grey levels.
inline double pixel_noise(const SensorModel& sensor, double grey) { return std::sqrt(sensor.read_noise * sensor.read_noise + sensor.shot_noise * grey); }

/// The nearest grey level that there is.
inline std::uint8_t whole_grey(double grey) { return static_cast<std::uint8_t>(std::clamp(grey + 0.5, 0.0, 255.0)); }

/// light^(1 / gamma), from a table with straight lines between its places: off by less than 2e-7 of the value.
class GammaCurve {
public:
    explicit GammaCurve(double gamma);
    /// From 2^-24 to 16; below is dark, above is as 16.
    float operator()(float light) const {
        if (!(light > darkest)) return 0;
        const std::uint32_t bits = std::bit_cast<std::uint32_t>(std::min(light, brightest)) - std::bit_cast<std::uint32_t>(darkest);
        const float part = static_cast<float>(bits & ((1U << part_bits) - 1)) * (1.0f / (1U << part_bits));
        const float* value = &values_[bits >> part_bits];
        return value[0] + part * (value[1] - value[0]);
    }

private:
    static constexpr float darkest = 0x1p-24f, brightest = 16;
    static constexpr int part_bits = 14;  // of a float's 23: 512 places from each power of two to the next
    std::vector<float> values_;
};

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
    void smear(std::vector<float>& light, int radius);

    int width_, height_;
    SensorModel model_;
    GammaCurve gamma_;
    GlareModel glare_;
    std::uint64_t seed_;
    std::vector<float> work_;
    std::vector<float> glow_;
    std::vector<double> sums_;
};

}  // namespace roomfix
