#include "roomfix/simulate/ceiling_scene.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "roomfix/base/decompositions.hpp"
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
    : model_(model), sensor_(model.width, model.height, sensor, glare, seed), width_(model.width), height_(model.height) {
    rays_.reserve(static_cast<std::size_t>(4 * width_ * height_));
    for (int y = 0; y < height_; ++y) {
        std::optional<Eigen::Vector2d> ray;
        for (int x = 0; x < width_; ++x) {
            for (int i = 0; i < 4; ++i) {
                ray = unproject_beside(model, {x + 0.5 * (i & 1) - 0.25, y + 0.5 * (i >> 1) - 0.25}, ray);
                rays_.push_back(ray ? Eigen::Vector3f(ray->homogeneous().cast<float>()) : Eigen::Vector3f(Eigen::Vector3f::Zero()));
            }
        }
    }
    light_.resize(static_cast<std::size_t>(width_ * height_));
}

void CeilingRenderer::trace(const CeilingScene& scene, const RowPoses& map_from_camera) {
    const std::vector<PlacedPatch> patches(scene.patches.begin(), scene.patches.end());
    if (scene.patches.empty() && scene.tile_light == 0 && scene.rail_light == 0) {
        std::fill(light_.begin(), light_.end(), 0.0f);
        return;
    }
    std::size_t p = 0;
    for (int y = 0; y < height_; ++y) {
        const Eigen::Matrix3f rotation = map_from_camera.of(y).linear().cast<float>();
        const Eigen::Vector3f origin = map_from_camera.of(y).translation().cast<float>();
        const float rise = static_cast<float>(scene.height) - origin.z();
        for (int x = 0; x < width_; ++x, ++p) {
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
}

/// One of the points of a disc, where each row shows it.
void CeilingRenderer::add_point(const CeilingDisc& disc, const Eigen::Vector3d& point, const RowPoses& map_from_camera) {
    const double scale = 1 / (sensor_.model().blur * std::numbers::sqrt2);
    const auto part = [&](double low) {  // of a point's light that falls on the pixel from `low` to `low` + 1
        return 0.5 * (std::erf((low + 1) * scale) - std::erf(low * scale));
    };
    View view{model_, {map_from_camera.of(height_ / 2), Matrix6d::Zero()}};
    ViewJacobian jacobian;
    const auto seen_by = [&](int row) {
        view.map_from_camera.pose = map_from_camera.of(row);
        return project_map_point(view, point, &jacobian);
    };
    auto pixel = seen_by(height_ / 2);
    // It is shown by the rows that are exposed while it is there.
    for (int i = 0; i < 3 && pixel && !map_from_camera.all_at_once(); ++i) pixel = seen_by(static_cast<int>(std::lround(pixel->y())));
    if (!pixel || !model_.contains(*pixel, -20)) return;
    const int reach = static_cast<int>(std::ceil(5 * sensor_.model().blur)) + 1;
    const int middle_x = static_cast<int>(std::lround(pixel->x()));
    const int middle_y = static_cast<int>(std::lround(pixel->y()));
    for (int y = std::max(middle_y - reach, 0); y <= std::min(middle_y + reach, height_ - 1); ++y) {
        if (!map_from_camera.all_at_once()) pixel = seen_by(y);
        if (!pixel) continue;
        const double area = std::abs(jacobian.by_point.leftCols<2>().determinant()) * std::numbers::pi * disc.radius * disc.radius / disc_points;
        const double row = area * static_cast<double>(disc.light) * part(y - 0.5 - pixel->y());
        for (int x = std::max(middle_x - reach, 0); x <= std::min(middle_x + reach, width_ - 1); ++x) {
            light_[static_cast<std::size_t>(y * width_ + x)] += static_cast<float>(row * part(x - 0.5 - pixel->x()));
        }
    }
}

/// Discs smaller than a pixel: each of their points is blurred first and integrated over the pixels then, as light is.
void CeilingRenderer::add_discs(const CeilingScene& scene, const RowPoses& map_from_camera) {
    for (const CeilingDisc& disc : scene.discs) {
        for (int i = 0; i < disc_points; ++i) {
            // A sunflower's seeds cover the disc evenly.
            const double radius = disc.radius * std::sqrt((i + 0.5) / disc_points);
            const double angle = i * std::numbers::pi * (3 - std::sqrt(5.0));
            add_point(disc, {disc.centre.x() + radius * std::cos(angle), disc.centre.y() + radius * std::sin(angle), scene.height}, map_from_camera);
        }
    }
}

const std::vector<float>& CeilingRenderer::expose(const CeilingScene& scene, const RowPoses& map_from_camera, double gain) {
    trace(scene, map_from_camera);
    sensor_.blur(light_);
    add_discs(scene, map_from_camera);
    sensor_.add_glare(light_);
    sensor_.expose(light_, gain);
    return light_;
}

void CeilingRenderer::render(const CeilingScene& scene, const RowPoses& map_from_camera, double gain, std::uint64_t index, LumaImage& frame) {
    sensor_.take(expose(scene, map_from_camera, gain), index, frame);
}

}  // namespace roomfix
