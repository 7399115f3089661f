#include "roomfix/simulate/camera_renderer.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "roomfix/base/random.hpp"
#include "roomfix/simulate/row_sums.hpp"

namespace roomfix {
namespace {

constexpr int blur_reach = 4;
/// Rays through a pixel in which an edge runs: no two of the lattice are in one row or column.
struct Lattice {
    int points, step;
};
constexpr Lattice face_lattice{32, 13};
constexpr Lattice shadow_lattice{16, 7};    // shadows are soft: their edges need less
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

/// Working memory of the blur: a row of pixels as far as the blur reaches, and what was blurred along rows.
struct BlurRows {
    std::vector<float> mean, right, down;
    std::vector<float> light_across, down_across;

    void start(std::size_t columns, std::size_t count) {
        for (auto* row : {&mean, &right, &down}) row->resize(columns + 2 * blur_reach);
        for (auto* rows : {&light_across, &down_across}) rows->assign(columns * count, 0);
    }
};

/// Two numbers from 0 to 1 of random bits.
Eigen::Vector2f two_of(std::uint64_t bits) {
    const auto uniform = [](std::uint64_t part) { return static_cast<float>(part & 0xffffff) * 0x1p-24f; };
    return {uniform(bits >> 40U), uniform(bits >> 8U)};
}

}  // namespace

CameraRenderer::CameraRenderer(const Scene& scene, const View& view, const SensorModel& sensor, std::uint64_t seed)
    : tracer_(scene),
      view_(view),
      sensor_(sensor),
      gamma_(sensor.gamma),
      seed_(seed),
      width_(view.model.width),
      height_(view.model.height),
      across_((width_ + cell_size - 1) / cell_size),
      down_((height_ + cell_size - 1) / cell_size),
      rays_(view.model, view.map_from_camera.pose.linear()) {
    const std::vector<Solid> nothing;
    const MovingSolids still = tracer_.with(nothing);
    still_.resize(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_));
    const Rectangle all{0, 0, width_ - 1, height_ - 1};
    for (int y = 0; y < height_; y += cell_size) {
        CellCorners corners;
        for (int x = 0; x < width_; x += cell_size) {
            still_floor_.push_back(trace_cell(x, y, all, still, corners, still_));
            still_surface_.push_back(surface_at(x, y, still));
        }
    }
    still_blurred_.resize(still_.size());
    blur(still_, all, still_blurred_);
}

CameraRenderer::Surface CameraRenderer::surface_at(int x, int y, const MovingSolids& moving) const {
    const Eigen::Vector3f d = rays_.within(std::min(x + cell_size / 2, width_ - 1), std::min(y + cell_size / 2, height_ - 1), 0.5f, 0.5f);
    if (d.isZero()) return {};
    const Sight sight = tracer_.look(moving, view_.position().cast<float>(), d.normalized());
    return {sight.face, sight.image, tracer_.illuminate(moving, sight, 0).lamps};
}

bool CameraRenderer::narrow(int x, int y, int size, MovingSolids& moving) const {
    const std::size_t stride = rays_.stride(), top = rays_.corner(x, y);
    const auto right = static_cast<std::size_t>(std::min(size, width_ - x));
    const std::size_t bottom = top + stride * static_cast<std::size_t>(std::min(size, height_ - y));
    const auto& corners = rays_.corners();
    tracer_.narrow(view_.position().cast<float>(), {corners[top], corners[top + right], corners[bottom], corners[bottom + right]}, moving);
    moving.walls = !still_floor_[static_cast<std::size_t>(y / cell_size * across_ + x / cell_size)];
    return moving.walls || !moving.none();  // shadows on walls are not told beforehand
}

/// Marks the grid cells of `area` that look different with `moving` in the scene, and their neighbours.
void CameraRenderer::mark_changed(const Rectangle& area, MovingSolids& moving) const {
    constexpr int block = 8;  // cells: most blocks have nothing to do with what moves
    changed_.assign(static_cast<std::size_t>(across_ * down_), 0);
    const auto look = [&](int i, int j) {
        if (!narrow(i * cell_size, j * cell_size, cell_size, moving)) return;
        if (surface_at(i * cell_size, j * cell_size, moving) == still_surface_[static_cast<std::size_t>(j * across_ + i)]) return;
        for (int v = std::max(j - 1, 0); v <= std::min(j + 1, down_ - 1); ++v) {
            for (int u = std::max(i - 1, 0); u <= std::min(i + 1, across_ - 1); ++u) changed_[static_cast<std::size_t>(v * across_ + u)] = 1;
        }
    };
    const int right = area.right / cell_size, bottom = area.bottom / cell_size;
    for (int top = area.top / cell_size; top <= bottom; top += block) {
        for (int left = area.left / cell_size; left <= right; left += block) {
            narrow(left * cell_size, top * cell_size, block * cell_size, moving);
            const bool nothing = moving.none();
            for (int j = top; j <= std::min(top + block - 1, bottom); ++j) {
                for (int i = left; i <= std::min(left + block - 1, right); ++i) {
                    if (!nothing || !still_floor_[static_cast<std::size_t>(j * across_ + i)]) look(i, j);
                }
            }
        }
    }
}

/// A ray from the camera. Dark where the lens sees nothing.
CameraRenderer::Ray CameraRenderer::ray(std::uint64_t jitter, const Eigen::Vector3f& direction, const MovingSolids& moving) const {
    Ray ray;
    if (direction.isZero()) return ray;
    ray.sight = tracer_.look(moving, view_.position().cast<float>(), direction.normalized());
    ray.falls = tracer_.illuminate(moving, ray.sight, jitter);
    return ray;
}

/// The rays of the pixels' corners where they agree on what they see, a lattice of them where they do not.
bool CameraRenderer::trace_cell(int left, int top, const Rectangle& area, const MovingSolids& moving, CellCorners& corners,
                                std::vector<PixelLight>& light) const {
    const int right = std::min(left + cell_size, width_), bottom = std::min(top + cell_size, height_);
    const auto at = [&](int x, int y) -> Ray& { return corners.rays[static_cast<std::size_t>((y - top) * (cell_size + 1) + x - left)]; };
    const bool known_left = corners.next == left;
    bool floor = true;
    for (int y = top; y <= bottom; ++y) {
        if (known_left) at(left, y) = at(left + cell_size, y);
        for (int x = left; x <= right; ++x) {
            const std::size_t number = rays_.corner(x, y);
            if (x > left || !known_left) at(x, y) = ray(mix64(seed_ ^ mix64(number)), rays_.corners()[number], moving);
            floor &= at(x, y).sight.floor;
        }
    }
    corners.next = right;
    for (int y = std::max(top, area.top); y < std::min(bottom, area.bottom + 1); ++y) {
        for (int x = std::max(left, area.left); x < std::min(right, area.right + 1); ++x) {
            const std::array<const Ray*, 4> around{&at(x, y), &at(x + 1, y), &at(x, y + 1), &at(x + 1, y + 1)};
            const bool alike = std::all_of(around.begin() + 1, around.end(),
                                           [&](const Ray* r) { return r->sight.same_faces(around[0]->sight) && r->falls.lamps == around[0]->falls.lamps; });
            PixelLight& pixel = light[static_cast<std::size_t>(y * width_ + x)];
            pixel = alike ? PixelLight{(around[0]->light() + around[1]->light() + around[2]->light() + around[3]->light()) / 4, 0, 0}
                          : edge_light(x, y, around, moving);
        }
    }
    return floor;
}

/// A pixel in which an edge runs. Only what is not the same in all of its corners is traced again: everything, the shadows' edges on a face,
/// or the joints between tiles.
CameraRenderer::PixelLight CameraRenderer::edge_light(int x, int y, const std::array<const Ray*, 4>& corners, const MovingSolids& moving) const {
    const auto all = [&](auto&& like_first) { return std::all_of(corners.begin(), corners.end(), [&](const Ray* r) { return like_first(*r, *corners[0]); }); };
    const bool same_faces = all([](const Ray& r, const Ray& first) { return r.sight.same_faces(first.sight); });
    const bool only_floor = moving.in_view.empty() && all([](const Ray& r, const Ray& first) { return r.sight.floor && r.sight.image == first.sight.image; });
    int lit = ~0, dark = ~0;  // lamps that all corners see, and that none does
    for (const Ray* r : corners) {
        lit &= r->falls.lamps;
        dark &= ~r->falls.lamps;
    }
    const auto within = [&](float u, float v, auto&& of) {
        const auto value = [&](std::size_t i) { return of(*corners[i]); };
        using Value = decltype(value(0));
        return Value((1 - v) * ((1 - u) * value(0) + u * value(1)) + v * ((1 - u) * value(2) + u * value(3)));
    };
    const Lattice lattice = same_faces ? shadow_lattice : face_lattice;
    const std::uint64_t bits = mix64(seed_ ^ mix64(static_cast<std::uint64_t>(y * width_ + x + 1) << 32U));  // beyond the corners' numbers
    const auto light_at = [&](int i, float u, float v) {
        const std::uint64_t jitter = bits + static_cast<std::uint64_t>(i) * (RayTracer::lamp_points / static_cast<std::uint64_t>(lattice.points));
        if (!same_faces && !only_floor) return ray(jitter, rays_.within(x, y, u, v), moving).light();
        Sight sight = corners[0]->sight;
        sight.place = within(u, v, [](const Ray& r) -> Eigen::Vector3f { return r.sight.place; });
        sight.added = within(u, v, [](const Ray& r) { return r.sight.added; });
        if (sight.floor) {
            sight.albedo = tracer_.floor_albedo(sight.place, sight.face);
        } else {
            sight.albedo = within(u, v, [](const Ray& r) { return r.sight.albedo; });
            sight.normal = within(u, v, [](const Ray& r) -> Eigen::Vector3f { return r.sight.normal; }).normalized();
        }
        const bool same_lamps = (lit | dark) == ~0;
        const float falls =
            same_lamps ? within(u, v, [](const Ray& r) { return r.falls.light; }) : tracer_.illuminate(moving, sight, jitter, {lit, dark}).light;
        return sight.albedo * falls + sight.added;
    };
    // Rows of rays would move edges that run along them, and so would one lattice for all: each pixel has its own shift.
    const Eigen::Vector2f shift = two_of(bits);
    const auto part = [](float value) { return value - std::floor(value); };
    const auto count = static_cast<float>(lattice.points);
    PixelLight sum;
    float mean_u = 0, mean_v = 0;
    for (int i = 0; i < lattice.points; ++i) {
        const float u = part((static_cast<float>(i) + 0.5f) / count + shift.x());
        const float v = part((static_cast<float>(i * lattice.step % lattice.points) + 0.5f) / count + shift.y());
        const float light = light_at(i, u, v) / count;
        sum.mean += light;
        sum.right += light * u;
        sum.down += light * v;
        mean_u += u / count;
        mean_v += v / count;
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
    const auto at = [&](int x, int y) { return static_cast<std::size_t>(y * width_ + x); };
    const int first = std::max(area.top - blur_reach, 0), last = std::min(area.bottom + blur_reach, height_ - 1);
    const auto columns = static_cast<std::size_t>(area.right - area.left + 1);
    thread_local BlurRows rows;
    rows.start(columns, static_cast<std::size_t>(last - first + 1));
    for (int y = first; y <= last; ++y) {
        for (std::size_t i = 0; i < rows.mean.size(); ++i) {
            const PixelLight& from = light[at(std::clamp(area.left - blur_reach + static_cast<int>(i), 0, width_ - 1), y)];
            rows.mean[i] = from.mean;
            rows.right[i] = from.right;
            rows.down[i] = from.down;
        }
        const std::size_t row = static_cast<std::size_t>(y - first) * columns;
        for (std::size_t k = 0; k < kernel.size(); ++k) {
            add_scaled(kernel[k], rows.mean.data() + k, slope[k], rows.right.data() + k, columns, rows.light_across.data() + row);
            add_scaled(kernel[k], rows.down.data() + k, columns, rows.down_across.data() + row);
        }
    }
    for (int y = area.top; y <= area.bottom; ++y) {
        float* to = blurred.data() + at(area.left, y);
        std::fill_n(to, columns, 0.0f);
        for (std::size_t k = 0; k < kernel.size(); ++k) {
            const int from = std::clamp(y - blur_reach + static_cast<int>(k), 0, height_ - 1);
            const std::size_t row = static_cast<std::size_t>(from - first) * columns;
            add_scaled(kernel[k], rows.light_across.data() + row, slope[k], rows.down_across.data() + row, columns, to);
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
        for (const Lamp& lamp : tracer_.scene().lamps) {
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

/// Where a cluster changes the light that falls; around it, only blur does.
CameraRenderer::Rectangle CameraRenderer::changed_by(const Cluster& cluster) const {
    const Rectangle& area = cluster.area;
    return {area.left > 0 ? area.left + blur_reach : 0, area.top > 0 ? area.top + blur_reach : 0,
            area.right < width_ - 1 ? area.right - blur_reach : area.right, area.bottom < height_ - 1 ? area.bottom - blur_reach : area.bottom};
}

/// A row of grid cells, those that were found to be changed.
void CameraRenderer::trace_cells(int row, const Rectangle& changed, MovingSolids& moving) const {
    CellCorners corners;
    for (int i = changed.left / cell_size; i <= changed.right / cell_size; ++i) {
        if (!changed_[static_cast<std::size_t>(row * across_ + i)] || !narrow(i * cell_size, row * cell_size, cell_size, moving)) continue;
        trace_cell(i * cell_size, row * cell_size, changed, moving, corners, traced_);
    }
}

void CameraRenderer::trace_cluster(const Cluster& cluster) const {
    copy_still(cluster.area);
    const Rectangle changed = changed_by(cluster);
    MovingSolids moving = tracer_.with(cluster.solids);
    mark_changed(changed, moving);
    for (int j = changed.top / cell_size; j <= changed.bottom / cell_size; ++j) trace_cells(j, changed, moving);
    blur(traced_, cluster.area, light_);
}

void CameraRenderer::render(const std::vector<Solid>& moving, double gain, std::uint64_t index, LumaImage& frame) const {
    light_ = still_blurred_;
    find_clusters(moving);
    for (const Cluster& cluster : clusters_) trace_cluster(cluster);
    develop(gain, index, frame);
}

void CameraRenderer::render_rows(const std::function<std::vector<Solid>(double row)>& moving_at, double gain, std::uint64_t index, LumaImage& frame) const {
    traced_ = still_;
    for (int row = 0; row < down_; ++row) {
        const int top = row * cell_size, bottom = top + cell_size - 1;
        find_clusters(moving_at(0.5 * (top + bottom)));
        for (const Cluster& cluster : clusters_) {
            const Rectangle changed = changed_by(cluster);
            // A cell changes with its neighbours.
            const Rectangle around{changed.left, std::max(changed.top, top - cell_size), changed.right, std::min(changed.bottom, bottom + cell_size)};
            if (around.top > around.bottom) continue;
            MovingSolids moving = tracer_.with(cluster.solids);
            mark_changed(around, moving);
            trace_cells(row, changed, moving);
        }
    }
    light_.resize(still_.size());
    blur(traced_, {0, 0, width_ - 1, height_ - 1}, light_);
    develop(gain, index, frame);
}

/// What the sensor makes of the light.
void CameraRenderer::develop(double gain, std::uint64_t index, LumaImage& frame) const {
    frame.resize(width_, height_);
    Random random(mix64(seed_ * 0x2545f4914f6cdd1dULL + index));
    const double phase = random.uniform(0, 2 * std::numbers::pi);
    const double half_diagonal = 0.25 * (width_ * width_ + height_ * height_);
    for (int y = 0; y < height_; ++y) {
        const double hum = 1 + sensor_.flicker * std::sin(phase + 1.5 * std::numbers::pi * y / height_);
        const double dy = y - 0.5 * height_;
        for (int x = 0; x < width_; ++x) {
            const double dx = x - 0.5 * width_;
            const double falloff = 1 - sensor_.vignetting * (dx * dx + dy * dy) / half_diagonal;
            const float light = light_[static_cast<std::size_t>(y * width_ + x)] * static_cast<float>(gain * hum * falloff * sensor_.exposure);
            const double grey = 255.0 * static_cast<double>(gamma_(light));
            frame.row(y)[x] = whole_grey(grey + random.normal(pixel_noise(sensor_, grey)));
        }
    }
}

}  // namespace roomfix
