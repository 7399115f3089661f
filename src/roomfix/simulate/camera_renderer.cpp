#include "roomfix/simulate/camera_renderer.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "roomfix/base/random.hpp"

namespace roomfix {
namespace {

constexpr int blur_reach = 4;
constexpr int cell_size = 4;        // px: one ray per cell finds out whether a robot or its shadow is there
constexpr int lattice_points = 32;  // rays through a pixel in which an edge runs
constexpr int lattice_step = 13;
constexpr int margin = 2 * blur_reach + 1;  // px around what changes: the blur's reach, and as much again to join the parts

std::array<float, 2 * blur_reach + 1> blur_kernel(double sigma) {
    std::array<float, 2 * blur_reach + 1> kernel{};
    float sum = 0;
    for (int i = -blur_reach; i <= blur_reach; ++i) {
        const double x = i / std::max(sigma, 1e-3);
        sum += kernel[static_cast<std::size_t>(i + blur_reach)] = static_cast<float>(std::exp(-0.5 * x * x));
    }
    for (float& k : kernel) k /= sum;
    return kernel;
}

}  // namespace

CameraRenderer::CameraRenderer(const Scene& scene, const View& view, const SensorModel& sensor, std::uint64_t seed)
    : scene_(scene),
      view_(view),
      sensor_(sensor),
      seed_(seed),
      width_(view.model.width),
      height_(view.model.height),
      rays_(view.model, view.map_from_camera.pose.linear()) {
    still_.resize(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_));
    for (int y = 0; y < height_; ++y) {
        for (int x = 0; x < width_; ++x) still_[static_cast<std::size_t>(y * width_ + x)] = traced(x, y, {});
    }
    for (int y = 0; y < height_; y += cell_size) {
        for (int x = 0; x < width_; x += cell_size) still_surface_.push_back(centre_ray(x + cell_size / 2, y + cell_size / 2, {}).surface);
    }
    still_blurred_.resize(still_.size());
    blur(still_, {0, 0, width_ - 1, height_ - 1}, still_blurred_);
}

RayHit CameraRenderer::centre_ray(int x, int y, const std::vector<Solid>& moving) const {
    const Eigen::Vector3f d = rays_.within(std::min(x, width_ - 1), std::min(y, height_ - 1), 0.5f, 0.5f);
    if (d.isZero()) return {};
    return trace(scene_, moving, view_.position().cast<float>(), d.normalized(), {0.5f, 0.5f});
}

/// Marks the grid cells of `area` that look different with `moving` in the scene, and their neighbours.
void CameraRenderer::mark_changed(const Rectangle& area, const std::vector<Solid>& moving) const {
    const int across = (width_ + cell_size - 1) / cell_size;
    const int down = (height_ + cell_size - 1) / cell_size;
    changed_.assign(static_cast<std::size_t>(across) * static_cast<std::size_t>(down), 0);
    for (int j = area.top / cell_size; j <= area.bottom / cell_size; ++j) {
        for (int i = area.left / cell_size; i <= area.right / cell_size; ++i) {
            const int surface = centre_ray(i * cell_size + cell_size / 2, j * cell_size + cell_size / 2, moving).surface;
            if (surface == still_surface_[static_cast<std::size_t>(j * across + i)]) continue;
            for (int v = std::max(j - 1, 0); v <= std::min(j + 1, down - 1); ++v) {
                for (int u = std::max(i - 1, 0); u <= std::min(i + 1, across - 1); ++u) changed_[static_cast<std::size_t>(v * across + u)] = 1;
            }
        }
    }
}

/// The rays of its corners where they agree on what they see, a lattice of them where they do not.
CameraRenderer::PixelLight CameraRenderer::traced(int x, int y, const std::vector<Solid>& moving) const {
    const Eigen::Vector3f origin = view_.position().cast<float>();
    const std::uint64_t pixel = static_cast<std::uint64_t>(y * width_ + x) * 64;
    const auto uniform = [](std::uint64_t bits) { return static_cast<float>(bits & 0xffffff) * 0x1p-24f; };
    const auto ray = [&](int number, float u, float v, int& surface) {
        const std::uint64_t h = mix64(seed_ ^ (pixel + static_cast<std::uint64_t>(number)));
        const Eigen::Vector3f d = rays_.within(x, y, u, v);
        if (d.isZero()) return 0.0f;
        const RayHit hit = trace(scene_, moving, origin, d.normalized(), {uniform(h >> 40U), uniform(h >> 8U)});
        surface = hit.surface;
        return hit.light;
    };
    PixelLight sum;
    int first = 0;
    bool alike = true;
    for (int i = 0; i < 4; ++i) {
        int surface = 0;
        sum.mean += ray(i, static_cast<float>(i & 1), static_cast<float>(i >> 1), surface) / 4;
        if (i == 0) first = surface;
        alike &= surface == first;
    }
    if (alike) return sum;
    // Rows of rays would move edges that run along them: no two of the lattice are in one row or column, and each pixel has its own shift.
    const std::uint64_t shift = mix64(seed_ ^ (pixel + 63));
    const float right = uniform(shift >> 40U), down = uniform(shift >> 8U);
    const auto part = [](float value) { return value - std::floor(value); };
    sum = {};
    int surface = 0;
    float mean_u = 0, mean_v = 0;
    for (int i = 0; i < lattice_points; ++i) {
        const float u = part((static_cast<float>(i) + 0.5f) / lattice_points + right);
        const float v = part((static_cast<float>(i * lattice_step % lattice_points) + 0.5f) / lattice_points + down);
        const float light = ray(4 + i, u, v, surface) / lattice_points;
        sum.mean += light;
        sum.right += light * u;
        sum.down += light * v;
        mean_u += u / lattice_points;
        mean_v += v / lattice_points;
    }
    // The lattice's own middle is not quite the pixel's: even light has none of these.
    sum.right -= sum.mean * mean_u;
    sum.down -= sum.mean * mean_v;
    return sum;
}

/// The lens blurs before the sensor samples: each pixel's light counts from where in its square it falls (the kernel's first two terms around
/// the middle), or lines thinner than a pixel would be found in the middles of pixels.
void CameraRenderer::blur(const std::vector<PixelLight>& light, const Rectangle& area, std::vector<float>& blurred) const {
    constexpr double pixel_variance = 1.0 / 12;  // px^2, of the square over which a pixel sums
    const double variance = sensor_.blur * sensor_.blur + pixel_variance;
    const auto kernel = blur_kernel(std::sqrt(variance));
    std::array<float, 2 * blur_reach + 1> slope{};  // change with the place where the light falls
    for (int i = -blur_reach; i <= blur_reach; ++i) {
        const auto k = static_cast<std::size_t>(i + blur_reach);
        slope[k] = -static_cast<float>(i / variance) * kernel[k];
    }
    struct Row {
        float light = 0, down = 0;
    };
    const auto at = [&](int x, int y) { return static_cast<std::size_t>(y * width_ + x); };
    thread_local std::vector<Row> across;
    across.resize(light.size());
    for (int y = std::max(area.top - blur_reach, 0); y <= std::min(area.bottom + blur_reach, height_ - 1); ++y) {
        for (int x = area.left; x <= area.right; ++x) {
            Row sum;
            for (int i = -blur_reach; i <= blur_reach; ++i) {
                const PixelLight& from = light[at(std::clamp(x + i, 0, width_ - 1), y)];
                const auto k = static_cast<std::size_t>(i + blur_reach);
                sum.light += kernel[k] * from.mean + slope[k] * from.right;
                sum.down += kernel[k] * from.down;
            }
            across[at(x, y)] = sum;
        }
    }
    for (int y = area.top; y <= area.bottom; ++y) {
        for (int x = area.left; x <= area.right; ++x) {
            float sum = 0;
            for (int i = -blur_reach; i <= blur_reach; ++i) {
                const Row& from = across[at(x, std::clamp(y + i, 0, height_ - 1))];
                const auto k = static_cast<std::size_t>(i + blur_reach);
                sum += kernel[k] * from.light + slope[k] * from.down;
            }
            blurred[at(x, y)] = sum;
        }
    }
}

/// The part of the image that a solid, its shadows and reflections can change.
CameraRenderer::Rectangle CameraRenderer::reach(const Solid& s) const {
    Rectangle area{width_, height_, -1, -1};
    const auto include = [&](const Eigen::Vector3f& p) {
        const auto pixel = project_map_point(view_, p.cast<double>());
        if (!pixel) return;
        area.left = std::min(area.left, static_cast<int>(std::floor(std::clamp(pixel->x(), -10.0, width_ + 10.0))) - margin);
        area.right = std::max(area.right, static_cast<int>(std::ceil(std::clamp(pixel->x(), -10.0, width_ + 10.0))) + margin);
        area.top = std::min(area.top, static_cast<int>(std::floor(std::clamp(pixel->y(), -10.0, height_ + 10.0))) - margin);
        area.bottom = std::max(area.bottom, static_cast<int>(std::ceil(std::clamp(pixel->y(), -10.0, height_ + 10.0))) + margin);
    };
    const float r = std::hypot(s.half.x(), s.half.y());
    for (int corner = 0; corner < 8; ++corner) {
        const Eigen::Vector3f offset((corner & 1 ? r : -r), (corner & 2 ? r : -r), corner & 4 ? s.half.z() : -s.half.z());
        const Eigen::Vector3f p = s.centre + offset;
        include(p);
        include({p.x(), p.y(), -p.z()});
        for (const Lamp& lamp : scene_.lamps) {
            const float rise = lamp.position.z() - p.z();
            if (rise < 0.2f) continue;
            const Eigen::Vector3f shadow = p + (p - lamp.position) * (p.z() / rise);
            if ((shadow - s.centre).norm() < 3) include(shadow);
        }
    }
    return {std::max(area.left, 0), std::max(area.top, 0), std::min(area.right, width_ - 1), std::min(area.bottom, height_ - 1)};
}

/// Around `area`, as far as its blur reaches.
void CameraRenderer::copy_still(const Rectangle& area) const {
    traced_.resize(still_.size());
    const auto left = std::max(area.left - blur_reach, 0), right = std::min(area.right + blur_reach, width_ - 1);
    for (int y = std::max(area.top - blur_reach, 0); y <= std::min(area.bottom + blur_reach, height_ - 1); ++y) {
        const auto row = static_cast<std::ptrdiff_t>(y) * width_;
        std::copy(still_.begin() + row + left, still_.begin() + row + right + 1, traced_.begin() + row + left);
    }
}

/// Solids whose parts of the picture overlap belong together; what another cluster does is not seen there.
void CameraRenderer::find_clusters(const std::vector<Solid>& moving) const {
    const auto apart = [](const Rectangle& a, const Rectangle& b) { return a.right < b.left || b.right < a.left || a.bottom < b.top || b.bottom < a.top; };
    clusters_.clear();
    for (const Solid& solid : moving) {
        Cluster joined{reach(solid), {solid}};
        if (joined.area.left > joined.area.right || joined.area.top > joined.area.bottom) continue;
        for (std::size_t c = 0; c < clusters_.size();) {
            const Cluster& other = clusters_[c];
            if (apart(joined.area, other.area)) {
                ++c;
                continue;
            }
            joined.area = {std::min(joined.area.left, other.area.left), std::min(joined.area.top, other.area.top),
                           std::max(joined.area.right, other.area.right), std::max(joined.area.bottom, other.area.bottom)};
            joined.solids.insert(joined.solids.end(), other.solids.begin(), other.solids.end());
            clusters_.erase(clusters_.begin() + static_cast<std::ptrdiff_t>(c));
            c = 0;  // it has grown: those that were apart may be no longer
        }
        clusters_.push_back(std::move(joined));
    }
}

void CameraRenderer::trace_cluster(const Cluster& cluster) const {
    const Rectangle& area = cluster.area;
    copy_still(area);
    const Rectangle changed{area.left > 0 ? area.left + blur_reach : 0, area.top > 0 ? area.top + blur_reach : 0,
                            area.right < width_ - 1 ? area.right - blur_reach : area.right, area.bottom < height_ - 1 ? area.bottom - blur_reach : area.bottom};
    mark_changed(changed, cluster.solids);
    const int across = (width_ + cell_size - 1) / cell_size;
    for (int y = changed.top; y <= changed.bottom; ++y) {
        for (int x = changed.left; x <= changed.right; ++x) {
            if (!changed_[static_cast<std::size_t>(y / cell_size * across + x / cell_size)]) continue;
            traced_[static_cast<std::size_t>(y * width_ + x)] = traced(x, y, cluster.solids);
        }
    }
    blur(traced_, area, light_);
}

void CameraRenderer::render(const std::vector<Solid>& moving, double gain, std::uint64_t index, LumaImage& frame) const {
    light_ = still_blurred_;
    find_clusters(moving);
    for (const Cluster& cluster : clusters_) trace_cluster(cluster);

    frame.resize(width_, height_);
    Random random(mix64(seed_ * 0x2545f4914f6cdd1dULL + index));
    const double phase = random.uniform(0, 2 * std::numbers::pi);
    const double half_diagonal = 0.25 * (width_ * width_ + height_ * height_);
    const float inverse_gamma = static_cast<float>(1 / sensor_.gamma);
    for (int y = 0; y < height_; ++y) {
        const double hum = 1 + sensor_.flicker * std::sin(phase + 1.5 * std::numbers::pi * y / height_);
        const double dy = y - 0.5 * height_;
        for (int x = 0; x < width_; ++x) {
            const double dx = x - 0.5 * width_;
            const double falloff = 1 - sensor_.vignetting * (dx * dx + dy * dy) / half_diagonal;
            const float light = light_[static_cast<std::size_t>(y * width_ + x)] * static_cast<float>(gain * hum * falloff * sensor_.exposure);
            const double grey = 255.0 * static_cast<double>(std::pow(std::max(light, 0.0f), inverse_gamma));
            frame.row(y)[x] = static_cast<std::uint8_t>(std::clamp(std::lround(grey + random.normal(pixel_noise(sensor_, grey))), 0L, 255L));
        }
    }
}

}  // namespace roomfix
