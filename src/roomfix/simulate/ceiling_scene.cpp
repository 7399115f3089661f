#include "roomfix/simulate/ceiling_scene.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "roomfix/base/random.hpp"

namespace roomfix {
namespace {

constexpr float rail_half_width = 0.012f;  // m
constexpr int disc_points = 24;

/// A patch with its turn worked out.
struct PlacedPatch {
    Eigen::Vector2f centre, half;
    float cosine, sine, light;

    explicit PlacedPatch(const CeilingPatch& patch)
        : centre(patch.centre.cast<float>()),
          half(patch.half.cast<float>()),
          cosine(static_cast<float>(std::cos(patch.yaw))),
          sine(static_cast<float>(std::sin(patch.yaw))),
          light(patch.light) {}
    bool holds(const Eigen::Vector2f& p) const {
        const Eigen::Vector2f d = p - centre;
        return std::abs(cosine * d.x() + sine * d.y()) <= half.x() && std::abs(-sine * d.x() + cosine * d.y()) <= half.y();
    }
};

float grain_at(const Eigen::Vector2f& p, std::uint64_t seed) {
    const auto cell = [](float v) { return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(v / 0.015f))); };
    return static_cast<float>(mix64(seed ^ (cell(p.x()) * 0x9e3779b97f4a7c15ULL + cell(p.y()) * 0xc2b2ae3d27d4eb4fULL)) >> 40U) * 0x1p-23f - 1;
}

float surface_light(const CeilingScene& scene, const std::vector<PlacedPatch>& patches, const Eigen::Vector2f& p) {
    for (auto patch = patches.rbegin(); patch != patches.rend(); ++patch) {
        if (patch->holds(p)) return patch->light;
    }
    const float tile = static_cast<float>(scene.tile);
    const auto off_rail = [&](float v) { return std::abs(v - std::round(v / tile) * tile); };
    const bool rail = std::min(off_rail(p.x()), off_rail(p.y())) < rail_half_width;
    return (rail ? scene.rail_light : scene.tile_light) * (1 + scene.grain * grain_at(p, scene.seed));
}

}  // namespace

void add_landmark(const SiteLandmark& landmark, const LandmarkLook& look, CeilingScene& scene) {
    const auto* triangle = std::get_if<LedTriangle>(&landmark.kind);
    if (!triangle) return;
    const Eigen::Isometry3d& pose = landmark.map_from_landmark;
    CeilingPatch panel;
    panel.centre = pose.translation().head<2>();
    panel.half = {triangle->a / 2 + look.margin, triangle->b / 2 + look.margin};
    panel.yaw = std::atan2(pose.linear()(1, 0), pose.linear()(0, 0));
    panel.light = look.panel_light;
    scene.patches.push_back(panel);
    const auto leds = map_points(landmark);
    for (std::size_t i = 0; i < leds.size(); ++i) {
        if (!look.dead[i]) scene.discs.push_back({leds[i].head<2>(), look.led_radius, look.led_light});
    }
}

CeilingRenderer::CeilingRenderer(const CameraModel& model, const SensorModel& sensor, const GlareModel& glare, std::uint64_t seed)
    : model_(model), sensor_(sensor), glare_(glare), seed_(seed), width_(model.width), height_(model.height) {
    rays_.reserve(static_cast<std::size_t>(4 * width_ * height_));
    for (int y = 0; y < height_; ++y) {
        for (int x = 0; x < width_; ++x) {
            for (int i = 0; i < 4; ++i) {
                const auto ray = unproject(model, {x + 0.5 * (i & 1) - 0.25, y + 0.5 * (i >> 1) - 0.25});
                rays_.push_back(ray ? Eigen::Vector3f(ray->homogeneous().cast<float>()) : Eigen::Vector3f(Eigen::Vector3f::Zero()));
            }
        }
    }
    light_.resize(static_cast<std::size_t>(width_ * height_));
}

void CeilingRenderer::trace(const CeilingScene& scene, const Eigen::Isometry3d& map_from_camera) {
    const std::vector<PlacedPatch> patches(scene.patches.begin(), scene.patches.end());
    const Eigen::Matrix3f rotation = map_from_camera.linear().cast<float>();
    const Eigen::Vector3f origin = map_from_camera.translation().cast<float>();
    const float rise = static_cast<float>(scene.height) - origin.z();
    if (scene.patches.empty() && scene.tile_light == 0 && scene.rail_light == 0) {
        std::fill(light_.begin(), light_.end(), 0.0f);
        return;
    }
    for (std::size_t p = 0; p < light_.size(); ++p) {
        float sum = 0;
        for (std::size_t i = 0; i < 4; ++i) {
            const Eigen::Vector3f d = rotation * rays_[4 * p + i];
            if (d.z() < 0.05f) continue;  // walls are dark
            const Eigen::Vector2f place = origin.head<2>() + d.head<2>() * (rise / d.z());
            sum += surface_light(scene, patches, place);
        }
        light_[p] = sum / 4;
    }
}

/// Discs smaller than a pixel: each of their points is blurred first and integrated over the pixels then, as light is.
void CeilingRenderer::add_discs(const CeilingScene& scene, const Eigen::Isometry3d& map_from_camera) {
    const View view{model_, {map_from_camera, Matrix6d::Zero()}};
    const auto part = [&](double low) {  // of a point's light that falls on the pixel from `low` to `low` + 1
        const double scale = 1 / (sensor_.blur * std::numbers::sqrt2);
        return 0.5 * (std::erf((low + 1) * scale) - std::erf(low * scale));
    };
    const int reach = static_cast<int>(std::ceil(5 * sensor_.blur)) + 1;
    for (const CeilingDisc& disc : scene.discs) {
        for (int i = 0; i < disc_points; ++i) {
            // A sunflower's seeds cover the disc evenly.
            const double radius = disc.radius * std::sqrt((i + 0.5) / disc_points);
            const double angle = i * std::numbers::pi * (3 - std::sqrt(5.0));
            ViewJacobian jacobian;
            const Eigen::Vector3d point(disc.centre.x() + radius * std::cos(angle), disc.centre.y() + radius * std::sin(angle), scene.height);
            const auto pixel = project_map_point(view, point, &jacobian);
            if (!pixel || !model_.contains(*pixel, -20)) continue;
            const double area = std::abs(jacobian.by_point.leftCols<2>().determinant()) * std::numbers::pi * disc.radius * disc.radius / disc_points;
            const int middle_x = static_cast<int>(std::lround(pixel->x()));
            const int middle_y = static_cast<int>(std::lround(pixel->y()));
            for (int y = std::max(middle_y - reach, 0); y <= std::min(middle_y + reach, height_ - 1); ++y) {
                const double row = area * static_cast<double>(disc.light) * part(y - 0.5 - pixel->y());
                for (int x = std::max(middle_x - reach, 0); x <= std::min(middle_x + reach, width_ - 1); ++x) {
                    light_[static_cast<std::size_t>(y * width_ + x)] += static_cast<float>(row * part(x - 0.5 - pixel->x()));
                }
            }
        }
    }
}

/// The lens: a Gaussian of the sensor's blur.
void CeilingRenderer::blur() {
    const int reach = std::max(1, static_cast<int>(std::ceil(4 * sensor_.blur)));
    std::vector<float> kernel;
    float sum = 0;
    for (int i = -reach; i <= reach; ++i) sum += kernel.emplace_back(static_cast<float>(std::exp(-0.5 * i * i / (sensor_.blur * sensor_.blur))));
    for (float& k : kernel) k /= sum;
    work_.resize(light_.size());
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
    pass(light_, work_, width_, 1, height_, width_);
    pass(work_, light_, height_, width_, width_, 1);
}

/// Three running means are nearly a Gaussian; the wide skirt of real glare comes from a second, wider one.
void CeilingRenderer::add_glare() {
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
    const std::vector<float> sharp = light_;
    for (const double scale : {0.6, 2.0}) {
        glow_ = sharp;
        const int radius = std::max(1, static_cast<int>(std::lround(0.5 * scale * glare_.reach)));
        for (int round = 0; round < 3; ++round) {
            running_mean(glow_, radius, width_, 1, height_, width_);
            running_mean(glow_, radius, height_, width_, width_, 1);
        }
        const float part = static_cast<float>(0.5 * glare_.part);
        for (std::size_t i = 0; i < light_.size(); ++i) light_[i] += part * (glow_[i] - sharp[i]);
    }
}

const std::vector<float>& CeilingRenderer::expose(const CeilingScene& scene, const Eigen::Isometry3d& map_from_camera, double gain) {
    trace(scene, map_from_camera);
    blur();
    add_discs(scene, map_from_camera);
    if (glare_.part > 0) add_glare();
    const double half_diagonal = 0.25 * (width_ * width_ + height_ * height_);
    for (int y = 0; y < height_; ++y) {
        for (int x = 0; x < width_; ++x) {
            const double dx = x - 0.5 * width_;
            const double dy = y - 0.5 * height_;
            const double falloff = 1 - sensor_.vignetting * (dx * dx + dy * dy) / half_diagonal;
            float& light = light_[static_cast<std::size_t>(y * width_ + x)];
            light = 255 * std::pow(std::max(light, 0.0f) * static_cast<float>(gain * falloff * sensor_.exposure), static_cast<float>(1 / sensor_.gamma));
        }
    }
    return light_;
}

void CeilingRenderer::render(const CeilingScene& scene, const Eigen::Isometry3d& map_from_camera, double gain, std::uint64_t index, LumaImage& frame) {
    const auto& exposed = expose(scene, map_from_camera, gain);
    frame.resize(width_, height_);
    Random random(mix64(seed_ * 0x2545f4914f6cdd1dULL + index));
    const double phase = random.uniform(0, 2 * std::numbers::pi);
    for (int y = 0; y < height_; ++y) {
        const double hum = 1 + sensor_.flicker / sensor_.gamma * std::sin(phase + 1.5 * std::numbers::pi * y / height_);
        for (int x = 0; x < width_; ++x) {
            const double grey = hum * static_cast<double>(exposed[static_cast<std::size_t>(y * width_ + x)]);
            // What is beyond the sensor's range is cut off before the noise of the converter.
            const double noise = pixel_noise(sensor_, std::min(grey, 300.0));
            frame.row(y)[x] = static_cast<std::uint8_t>(std::clamp(std::lround(std::min(grey, 300.0) + random.normal(noise)), 0L, 255L));
        }
    }
}

double pixel_noise(const SensorModel& sensor, double grey) { return std::sqrt(sensor.read_noise * sensor.read_noise + sensor.shot_noise * grey); }

}  // namespace roomfix
