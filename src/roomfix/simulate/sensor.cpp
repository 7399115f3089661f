#include "roomfix/simulate/sensor.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "roomfix/base/random.hpp"
#include "roomfix/simulate/row_sums.hpp"

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
    work_.assign(light.size(), 0);
    const auto width = static_cast<std::size_t>(width_), beyond = static_cast<std::size_t>(reach);
    std::vector<float> row(width + 2 * beyond);  // goes on as it ends
    for (std::size_t start = 0; start < light.size(); start += width) {
        const float* from = light.data() + start;
        std::fill_n(row.begin(), beyond, from[0]);
        std::copy_n(from, width, row.begin() + reach);
        std::fill_n(row.begin() + reach + width_, beyond, from[width - 1]);
        for (std::size_t k = 0; k < kernel.size(); ++k) add_scaled(kernel[k], row.data() + k, width, work_.data() + start);
    }
    std::fill(light.begin(), light.end(), 0.0f);
    for (int y = 0; y < height_; ++y) {
        for (int k = -reach; k <= reach; ++k) {
            const auto from = static_cast<std::size_t>(std::clamp(y + k, 0, height_ - 1)) * width;
            add_scaled(kernel[static_cast<std::size_t>(k + reach)], work_.data() + from, width, light.data() + static_cast<std::size_t>(y) * width);
        }
    }
}

/// Running means over 2 radius + 1 places, along rows and then down columns; all columns at once, as they lie in memory.
void Sensor::smear(std::vector<float>& light, int radius) {
    const double places = 2 * radius + 1;
    work_.resize(light.size());
    for (int y = 0; y < height_; ++y) {
        const float* row = light.data() + static_cast<std::ptrdiff_t>(y) * width_;
        float* means = work_.data() + static_cast<std::ptrdiff_t>(y) * width_;
        const auto at = [&](int x) { return row[std::clamp(x, 0, width_ - 1)]; };
        double sum = 0;
        for (int x = -radius; x <= radius; ++x) sum += static_cast<double>(at(x));
        for (int x = 0; x < width_; ++x) {
            means[x] = static_cast<float>(sum / places);
            sum += static_cast<double>(at(x + radius + 1) - at(x - radius));
        }
    }
    const auto row_at = [&](int y) { return work_.data() + static_cast<std::ptrdiff_t>(std::clamp(y, 0, height_ - 1)) * width_; };
    sums_.assign(static_cast<std::size_t>(width_), 0);
    for (int y = -radius; y <= radius; ++y) {
        const float* row = row_at(y);
        for (std::size_t x = 0; x < sums_.size(); ++x) sums_[x] += static_cast<double>(row[x]);
    }
    for (int y = 0; y < height_; ++y) {
        float* means = light.data() + static_cast<std::ptrdiff_t>(y) * width_;
        const float *in = row_at(y + radius + 1), *out = row_at(y - radius);
        for (std::size_t x = 0; x < sums_.size(); ++x) {
            means[x] = static_cast<float>(sums_[x] / places);
            sums_[x] += static_cast<double>(in[x] - out[x]);
        }
    }
}

/// Three running means are nearly a Gaussian; the wide skirt of real glare comes from a second, wider one.
void Sensor::add_glare(std::vector<float>& light) {
    if (!(glare_.part > 0)) return;
    const std::vector<float> sharp = light;
    for (const double scale : {0.6, 2.0}) {
        glow_ = sharp;
        const int radius = std::max(1, static_cast<int>(std::lround(0.5 * scale * glare_.reach)));
        for (int round = 0; round < 3; ++round) smear(glow_, radius);
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
