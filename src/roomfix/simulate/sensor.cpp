#include "roomfix/simulate/sensor.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "roomfix/base/random.hpp"

namespace roomfix {

GammaCurve::GammaCurve(double gamma) {
    const std::uint32_t first = std::bit_cast<std::uint32_t>(darkest), last = std::bit_cast<std::uint32_t>(brightest);
    for (std::uint32_t bits = first; bits <= last + (1U << part_bits); bits += 1U << part_bits) {
        values_.push_back(static_cast<float>(std::pow(static_cast<double>(std::bit_cast<float>(bits)), 1 / gamma)));
    }
}

Sensor::Sensor(int width, int height, const SensorModel& model, const GlareModel& glare, std::uint64_t seed)
    : width_(width), height_(height), model_(model), gamma_(model.gamma), glare_(glare), seed_(seed) {}

void Sensor::blur(std::vector<float>& light) {
    const int reach = std::max(1, static_cast<int>(std::ceil(4 * model_.blur)));
    std::vector<float> kernel;
    float sum = 0;
    for (int i = -reach; i <= reach; ++i) sum += kernel.emplace_back(static_cast<float>(std::exp(-0.5 * i * i / (model_.blur * model_.blur))));
    for (float& k : kernel) k /= sum;
    work_.resize(light.size());
    const auto pass = [&](const std::vector<float>& from, std::vector<float>& to, int count, int step, int lines, int line_step) {
        for (int line = 0; line < lines; ++line) {
            for (int i = 0; i < count; ++i) {
                float value = 0;
                for (int k = -reach; k <= reach; ++k) {
                    const int j = std::clamp(i + k, 0, count - 1);
                    value += kernel[static_cast<std::size_t>(k + reach)] * from[static_cast<std::size_t>(line * line_step + j * step)];
                }
                to[static_cast<std::size_t>(line * line_step + i * step)] = value;
            }
        }
    };
    pass(light, work_, width_, 1, height_, width_);
    pass(work_, light, height_, width_, width_, 1);
}

/// Three running means are nearly a Gaussian; the wide skirt of real glare comes from a second, wider one.
void Sensor::add_glare(std::vector<float>& light) {
    if (!(glare_.part > 0)) return;
    const auto running_mean = [&](std::vector<float>& v, int radius, int count, int step, int lines, int line_step) {
        work_.resize(v.size());
        for (int line = 0; line < lines; ++line) {
            const auto at = [&](int i) { return v[static_cast<std::size_t>(line * line_step + std::clamp(i, 0, count - 1) * step)]; };
            double sum = 0;
            for (int i = -radius; i <= radius; ++i) sum += static_cast<double>(at(i));
            for (int i = 0; i < count; ++i) {
                work_[static_cast<std::size_t>(line * line_step + i * step)] = static_cast<float>(sum / (2 * radius + 1));
                sum += static_cast<double>(at(i + radius + 1) - at(i - radius));
            }
        }
        v.swap(work_);
    };
    const std::vector<float> sharp = light;
    for (const double scale : {0.6, 2.0}) {
        glow_ = sharp;
        const int radius = std::max(1, static_cast<int>(std::lround(0.5 * scale * glare_.reach)));
        for (int round = 0; round < 3; ++round) {
            running_mean(glow_, radius, width_, 1, height_, width_);
            running_mean(glow_, radius, height_, width_, width_, 1);
        }
        const float part = static_cast<float>(0.5 * glare_.part);
        for (std::size_t i = 0; i < light.size(); ++i) light[i] += part * (glow_[i] - sharp[i]);
    }
}

void Sensor::expose(std::vector<float>& light, double gain) const {
    const double half_diagonal = 0.25 * (width_ * width_ + height_ * height_);
    for (int y = 0; y < height_; ++y) {
        for (int x = 0; x < width_; ++x) {
            const double dx = x - 0.5 * width_;
            const double dy = y - 0.5 * height_;
            const double falloff = 1 - model_.vignetting * (dx * dx + dy * dy) / half_diagonal;
            float& at = light[static_cast<std::size_t>(y * width_ + x)];
            at = 255 * gamma_(at * static_cast<float>(gain * falloff * model_.exposure));
        }
    }
}

void Sensor::take(const std::vector<float>& exposed, std::uint64_t index, LumaImage& frame) const {
    frame.resize(width_, height_);
    Random random(mix64(seed_ * 0x2545f4914f6cdd1dULL + index));
    const double phase = random.uniform(0, 2 * std::numbers::pi);
    for (int y = 0; y < height_; ++y) {
        const double hum = 1 + model_.flicker / model_.gamma * std::sin(phase + 1.5 * std::numbers::pi * y / height_);
        for (int x = 0; x < width_; ++x) {
            const double grey = hum * static_cast<double>(exposed[static_cast<std::size_t>(y * width_ + x)]);
            // What is beyond the sensor's range is cut off before the noise of the converter.
            const double noise = pixel_noise(model_, std::min(grey, 300.0));
            frame.row(y)[x] = whole_grey(std::min(grey, 300.0) + random.normal(noise));
        }
    }
}

}  // namespace roomfix
