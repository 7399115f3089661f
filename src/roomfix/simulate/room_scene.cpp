#include "roomfix/simulate/room_scene.hpp"

#include <algorithm>
#include <cmath>

#include "roomfix/simulate/lattice_noise.hpp"

namespace roomfix {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;

constexpr int lattice_points = 64;  // rays through a pixel in which an edge runs
constexpr int lattice_step = 19;    // a rank-1 lattice: 64 different columns, 64 different rows

struct Wall {
    Vector2f from, along, inward;
    float length, albedo;
};
/// A panel with its turn worked out.
struct PlacedPanel {
    Eigen::Vector2d centre, half;
    double cosine, sine;
    float albedo, glow;
};
struct PlacedBox {
    Vector3f centre, half;
    float cosine, sine, albedo;

    Vector3f own(const Vector3f& v) const { return {cosine * v.x() + sine * v.y(), -sine * v.x() + cosine * v.y(), v.z()}; }
    Vector3f back(const Vector3f& v) const { return {cosine * v.x() - sine * v.y(), sine * v.x() + cosine * v.y(), v.z()}; }
};

/// What a ray meets: where, on what.
struct Meeting {
    float distance = 1e30f;
    Vector3f normal = Vector3f::UnitZ();
    float albedo = 0.5f;
    float glow = 0;
    float texture = 1;
    int surface = 0;  // equal numbers look alike
};

/// Smooth noise in -1..1 over a plane.
float plane_noise(float u, float v, int plane, std::uint64_t seed) {
    const float iu = std::floor(u);
    const float iv = std::floor(v);
    const int x = static_cast<int>(iu);
    const int y = static_cast<int>(iv);
    const float fu = u - iu;
    const float fv = v - iv;
    return (1 - fv) * ((1 - fu) * lattice_noise(x, y, plane, seed) + fu * lattice_noise(x + 1, y, plane, seed)) +
           fv * ((1 - fu) * lattice_noise(x, y + 1, plane, seed) + fu * lattice_noise(x + 1, y + 1, plane, seed));
}

/// A scene with everything worked out that does not depend on the ray.
class Tracer {
public:
    explicit Tracer(const RoomScene& scene) : scene_(scene), height_(static_cast<float>(scene.height)) {
        for (std::size_t i = 0; i < scene.walls.size(); ++i) {
            const Vector2f from = scene.walls[i].cast<float>();
            const Vector2f to = scene.walls[(i + 1) % scene.walls.size()].cast<float>();
            const Vector2f along = (to - from).normalized();
            walls_.push_back({from, along, {-along.y(), along.x()}, (to - from).norm(), i < scene.wall_albedo.size() ? scene.wall_albedo[i] : 0.7f});
        }
        for (const CeilingPanel& panel : scene.panels) {
            panels_.push_back({panel.centre, panel.half, std::cos(panel.yaw), std::sin(panel.yaw), panel.albedo, panel.glow});
        }
        for (const RoomBox& box : scene.boxes) {
            boxes_.push_back(
                {box.centre.cast<float>(), box.half.cast<float>(), static_cast<float>(std::cos(box.yaw)), static_cast<float>(std::sin(box.yaw)), box.albedo});
        }
    }

    /// Light along a ray; `surface` tells what it met.
    float light(const Vector3f& origin, const Vector3f& direction, int& surface) const {
        Meeting hit;
        meet_room(origin, direction, hit);
        for (std::size_t i = 0; i < boxes_.size(); ++i) meet_box(boxes_[i], static_cast<int>(i), origin, direction, hit);
        surface = hit.surface;
        const Vector3f place = origin + hit.distance * direction;
        return hit.glow + hit.albedo * hit.texture * illumination(place, hit.normal, surface);
    }

private:
    void meet_room(const Vector3f& o, const Vector3f& d, Meeting& hit) const {
        if (d.z() > 1e-6f) {
            const float distance = (height_ - o.z()) / d.z();
            hit = {distance, -Vector3f::UnitZ(), scene_.ceiling_albedo, 0, 1, 1};
        } else if (d.z() < -1e-6f) {
            hit = {-o.z() / d.z(), Vector3f::UnitZ(), scene_.floor_albedo, 0, 1, 2};
        }
        std::size_t nearest = walls_.size();
        for (std::size_t i = 0; i < walls_.size(); ++i) {
            const float approach = walls_[i].inward.dot(d.head<2>());
            if (approach > -1e-9f) continue;
            const float distance = walls_[i].inward.dot(walls_[i].from - o.head<2>()) / approach;
            if (distance < hit.distance) {
                hit.distance = distance;
                nearest = i;
            }
        }
        const Vector3f place = o + hit.distance * d;
        if (nearest < walls_.size()) {
            on_wall(nearest, place, hit);
        } else if (hit.surface == 1) {
            on_ceiling(place, hit);
        }
        if (scene_.moulding > 0) meet_moulding(o, d, hit);
    }

    /// A moulding is a plane that cuts off the edge between wall and ceiling.
    void meet_moulding(const Vector3f& o, const Vector3f& d, Meeting& hit) const {
        const float size = static_cast<float>(scene_.moulding);
        const float slope = static_cast<float>(scene_.moulding_slope);
        for (std::size_t i = 0; i < walls_.size(); ++i) {
            if (i < scene_.moulded.size() && !scene_.moulded[i]) continue;
            const float approach = walls_[i].inward.dot(d.head<2>()) - slope * d.z();
            const float gap = walls_[i].inward.dot(o.head<2>() - walls_[i].from) + slope * height_ - slope * o.z() - slope * size;  // times sqrt(1 + slope^2)
            if (approach > -1e-9f || gap < 0) continue;
            const float distance = gap / -approach;
            if (distance >= hit.distance) continue;
            const Vector3f normal = Vector3f(walls_[i].inward.x(), walls_[i].inward.y(), -slope).normalized();
            hit = {distance, normal, scene_.moulding_albedo, 0, 1, 100 + static_cast<int>(i)};
        }
    }

    void on_wall(std::size_t index, const Vector3f& place, Meeting& hit) const {
        const Wall& wall = walls_[index];
        const float along = wall.along.dot(place.head<2>() - wall.from);
        hit.normal = {wall.inward.x(), wall.inward.y(), 0};
        hit.albedo = wall.albedo;
        hit.glow = 0;
        hit.surface = 16 + static_cast<int>(index);
        const float size = static_cast<float>(scene_.texture_size);
        hit.texture = 1 + scene_.texture * plane_noise(along / size, place.z() / size, static_cast<int>(index), scene_.seed);
        if (scene_.crease > 0) {
            const float off = std::min(along, wall.length - along) / static_cast<float>(scene_.crease);
            hit.texture *= 1 - scene_.crease_depth * std::exp(-0.5f * off * off);
        }
        for (std::size_t i = scene_.patches.size(); i-- > 0;) {
            const WallPatch& patch = scene_.patches[i];
            if (patch.wall != index) continue;
            const double u = static_cast<double>(along);
            const double v = static_cast<double>(place.z());
            if (u < patch.low.x() || v < patch.low.y() || u > patch.high.x() || v > patch.high.y()) continue;
            const double inside = std::min(std::min(u - patch.low.x(), patch.high.x() - u), std::min(v - patch.low.y(), patch.high.y() - v));
            hit.surface = 1000 + 1000 * static_cast<int>(i);
            hit.albedo = patch.albedo;
            hit.glow = patch.glow;
            if (inside < patch.border) {
                hit.albedo = patch.border_albedo;
                hit.glow = 0;
                hit.surface += 1;
            } else if (patch.pattern > 0) {
                const int cell_u = static_cast<int>(std::floor(u / patch.pattern));
                const int cell_v = static_cast<int>(std::floor(v / patch.pattern));
                const float tone = lattice_noise(cell_u, cell_v, 77 + static_cast<int>(i), scene_.seed);
                hit.albedo = std::clamp(patch.albedo * (1 + 0.8f * tone), 0.03f, 0.95f);
                hit.surface += 2 + (((cell_u * 31 + cell_v * 17) % 900) + 900) % 900;
            }
            return;
        }
    }

    void on_ceiling(const Vector3f& place, Meeting& hit) const {
        for (std::size_t i = panels_.size(); i-- > 0;) {
            const PlacedPanel& panel = panels_[i];
            const Eigen::Vector2d off = place.head<2>().cast<double>() - panel.centre;
            const Eigen::Vector2d own(panel.cosine * off.x() + panel.sine * off.y(), -panel.sine * off.x() + panel.cosine * off.y());
            if (std::abs(own.x()) > panel.half.x() || std::abs(own.y()) > panel.half.y()) continue;
            hit.albedo = panel.albedo;
            hit.glow = panel.glow;
            hit.surface = 200 + static_cast<int>(i);
            return;
        }
    }

    static bool cross_box(const PlacedBox& box, const Vector3f& o, const Vector3f& d, float& enter, int& axis) {
        float leave = 1e30f;
        enter = 1e-4f;
        axis = -1;
        for (int i = 0; i < 3; ++i) {
            if (std::abs(d[i]) < 1e-12f) {
                if (std::abs(o[i]) > box.half[i]) return false;
                continue;
            }
            const float a = (-box.half[i] - o[i]) / d[i];
            const float b = (box.half[i] - o[i]) / d[i];
            if (std::min(a, b) > enter) {
                enter = std::min(a, b);
                axis = i;
            }
            leave = std::min(leave, std::max(a, b));
            if (enter >= leave) return false;
        }
        return axis >= 0;
    }

    void meet_box(const PlacedBox& box, int index, const Vector3f& origin, const Vector3f& direction, Meeting& hit) const {
        const Vector3f o = box.own(origin - box.centre);
        const Vector3f d = box.own(direction);
        float enter = 0;
        int axis = 0;
        if (!cross_box(box, o, d, enter, axis) || enter >= hit.distance) return;
        Vector3f normal = Vector3f::Zero();
        normal[axis] = d[axis] > 0 ? -1.0f : 1.0f;
        hit = {enter, box.back(normal), box.albedo, 0, 1, -(8 * index + 2 * axis + (d[axis] > 0) + 1)};
    }

    /// Light that reaches a place: from all around, less in corners, and from the lamps that nothing hides.
    float illumination(const Vector3f& place, const Vector3f& normal, int& surface) const {
        // A large surface at a right angle, a distance d away, hides the part (1 - d / sqrt(d^2 + s^2)) / 2 of what shines from all around.
        const float size = static_cast<float>(scene_.occlusion_size);
        const auto hiding = [&](float d) { return 1 - std::max(d, 0.0f) / std::sqrt(d * d + size * size); };
        float hides = 0;
        for (const Wall& wall : walls_) {
            if (std::abs(wall.inward.dot(normal.head<2>())) < 0.5f) hides += hiding(wall.inward.dot(place.head<2>() - wall.from));
        }
        if (std::abs(normal.z()) < 0.5f) hides += hiding(height_ - place.z()) + hiding(place.z());
        float light = scene_.ambient * (1 - scene_.occlusion * hides);
        int shadows = 0;
        for (std::size_t i = 0; i < scene_.lamps.size(); ++i) {
            const Vector3f to = scene_.lamps[i].position.cast<float>() - place;
            const float square = to.squaredNorm();
            const float distance = std::sqrt(square);
            const float cosine = normal.dot(to) / distance;
            if (cosine <= 0) continue;
            if (hidden(place, to / distance, distance)) {
                shadows |= 1 << i;
                continue;
            }
            light += scene_.lamps[i].power * cosine / square;
        }
        if (shadows) surface = surface * 8191 + shadows;
        return light;
    }

    bool hidden(const Vector3f& from, const Vector3f& direction, float distance) const {
        for (const PlacedBox& box : boxes_) {
            float enter = 0;
            int axis = 0;
            if (cross_box(box, box.own(from - box.centre), box.own(direction), enter, axis) && enter > 2e-3f && enter < distance) return true;
        }
        return false;
    }

    const RoomScene& scene_;
    float height_;
    std::vector<Wall> walls_;
    std::vector<PlacedPanel> panels_;
    std::vector<PlacedBox> boxes_;
};

}  // namespace

RoomRenderer::RoomRenderer(const CameraModel& model, const SensorModel& sensor, const GlareModel& glare, std::uint64_t seed)
    : sensor_(model.width, model.height, sensor, glare, seed), width_(model.width), height_(model.height), rays_(model) {
    corner_light_.resize(rays_.corners().size());
    corner_surface_.resize(rays_.corners().size());
    light_.resize(static_cast<std::size_t>(width_ * height_));
}

const std::vector<float>& RoomRenderer::expose(const RoomScene& scene, const RowPoses& map_from_camera, double gain) {
    const Tracer tracer(scene);
    Eigen::Matrix3f rotation;
    Vector3f origin;
    const auto go_to = [&](int row) {
        rotation = map_from_camera.of(row).linear().cast<float>();
        origin = map_from_camera.of(row).translation().cast<float>();
    };
    for (std::size_t i = 0; i < rays_.corners().size(); ++i) {
        if (i % rays_.stride() == 0) go_to(static_cast<int>(i / rays_.stride()));
        const Vector3f& ray = rays_.corners()[i];
        corner_light_[i] = 0;
        corner_surface_[i] = 0;
        if (ray.z() > 0) corner_light_[i] = tracer.light(origin, (rotation * ray).normalized(), corner_surface_[i]);
    }
    for (int y = 0; y < height_; ++y) {
        go_to(y);
        for (int x = 0; x < width_; ++x) {
            const std::size_t top = rays_.corner(x, y), bottom = top + rays_.stride();
            float& light = light_[static_cast<std::size_t>(y * width_ + x)];
            const int surface = corner_surface_[top];
            if (corner_surface_[top + 1] == surface && corner_surface_[bottom] == surface && corner_surface_[bottom + 1] == surface) {
                light = 0.25f * (corner_light_[top] + corner_light_[top + 1] + corner_light_[bottom] + corner_light_[bottom + 1]);
                continue;
            }
            float sum = 0;
            for (int i = 0; i < lattice_points; ++i) {
                const float fx = (static_cast<float>(i) + 0.5f) / lattice_points;
                const float fy = (static_cast<float>(i * lattice_step % lattice_points) + 0.5f) / lattice_points;
                const Vector3f ray = rays_.within(x, y, fx, fy);
                int ignored = 0;
                if (ray.z() > 0) sum += tracer.light(origin, (rotation * ray).normalized(), ignored);
            }
            light = sum / lattice_points;
        }
    }
    sensor_.blur(light_);
    sensor_.add_glare(light_);
    sensor_.expose(light_, gain);
    return light_;
}

void RoomRenderer::render(const RoomScene& scene, const RowPoses& map_from_camera, double gain, std::uint64_t index, LumaImage& frame) {
    sensor_.take(expose(scene, map_from_camera, gain), index, frame);
}

}  // namespace roomfix
