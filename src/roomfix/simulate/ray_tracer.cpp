#include "roomfix/simulate/ray_tracer.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <optional>

#include "roomfix/simulate/lattice_noise.hpp"

namespace roomfix {

using Eigen::Vector2f;
using Eigen::Vector3f;

struct RayTracer::Hit {
    float distance = 1e30f;
    Vector3f normal = Vector3f::UnitZ();
    Vector3f local = Vector3f::Zero();  // where on the surface, for its texture
    const Material* material = nullptr;
    int surface = 0;
};

namespace {

constexpr std::size_t at_once = 16;  // walls and lamps are looked at in lots of this many
constexpr std::size_t lamp_bits = 16;
constexpr float nearest = 1e-4f;      // m
constexpr float least_light = 0.01f;  // of a lamp's, to count
// Numbers of faces: from 1 on the floor's tiles, then walls, two each, then solids, eight each.
constexpr int first_wall_surface = 1 << 24;
constexpr int first_furniture_surface = 1 << 25;
constexpr int first_moving_surface = 1 << 26;

/// Value noise in -1..1 with cells of the given size, smooth between them.
float grain(const Vector3f& p, float size, std::uint64_t seed) {
    const Vector3f q = p / size;
    const Vector3f base(std::floor(q.x()), std::floor(q.y()), std::floor(q.z()));
    const Vector3f f = q - base;
    const auto x = static_cast<std::int64_t>(base.x()), y = static_cast<std::int64_t>(base.y()), z = static_cast<std::int64_t>(base.z());
    float sum = 0;
    for (int corner = 0; corner < 8; ++corner) {
        const int dx = corner & 1;
        const int dy = (corner >> 1) & 1;
        const int dz = corner >> 2;
        const float weight = (dx ? f.x() : 1 - f.x()) * (dy ? f.y() : 1 - f.y()) * (dz ? f.z() : 1 - f.z());
        sum += weight * lattice_noise(x + dx, y + dy, z + dz, seed);
    }
    return sum;
}

Vector3f turned(const Vector3f& v, float cosine, float sine) { return {cosine * v.x() + sine * v.y(), -sine * v.x() + cosine * v.y(), v.z()}; }

/// Distance along the ray to an upright solid and the local normal there; nothing if it misses.
std::optional<std::pair<float, Vector3f>> meet(const Solid& solid, const Vector3f& o, const Vector3f& d) {
    float enter = nearest;
    float leave = 1e30f;
    Vector3f normal = Vector3f::Zero();
    const auto slab = [&](int axis, float half) {
        if (std::abs(d[axis]) < 1e-12f) return std::abs(o[axis]) <= half;
        const float a = (-half - o[axis]) / d[axis];
        const float b = (half - o[axis]) / d[axis];
        if (std::min(a, b) > enter) {
            enter = std::min(a, b);
            normal = Vector3f::Zero();
            normal[axis] = d[axis] > 0 ? -1.0f : 1.0f;
        }
        leave = std::min(leave, std::max(a, b));
        return enter < leave;
    };
    if (!slab(2, solid.half.z())) return std::nullopt;
    if (!solid.round) {
        if (!slab(0, solid.half.x()) || !slab(1, solid.half.y())) return std::nullopt;
    } else {
        const float a = d.x() * d.x() + d.y() * d.y();
        const float b = o.x() * d.x() + o.y() * d.y();
        const float c = o.x() * o.x() + o.y() * o.y() - solid.half.x() * solid.half.x();
        const float root = b * b - a * c;
        if (root <= 0 || a < 1e-12f) {
            if (c > 0) return std::nullopt;
        } else {
            const float first = (-b - std::sqrt(root)) / a;
            if (first > enter) {
                enter = first;
                normal = Vector3f(o.x() + first * d.x(), o.y() + first * d.y(), 0).normalized();
            }
            leave = std::min(leave, (-b + std::sqrt(root)) / a);
        }
    }
    if (!(enter < leave) || normal.isZero()) return std::nullopt;
    return std::pair{enter, normal};
}

/// Whether the ray passes a sphere around the solid by.
bool passes_by(const Solid& solid, const Vector3f& to, const Vector3f& direction) {
    const float along = to.dot(direction);
    return (to - along * direction).squaredNorm() > solid.half.squaredNorm();
}

/// Where a ray meets a solid, in the solid's own frame.
struct SolidMeeting {
    float distance;
    Vector3f normal, place;
};
std::optional<SolidMeeting> meet_on_way(const Solid& solid, const Vector3f& origin, const Vector3f& direction) {
    if (passes_by(solid, solid.centre - origin, direction)) return std::nullopt;
    const float cosine = solid.axis.x(), sine = solid.axis.y();
    const Vector3f o = turned(origin - solid.centre, cosine, sine), d = turned(direction, cosine, sine);
    const auto met = meet(solid, o, d);
    if (!met) return std::nullopt;
    return SolidMeeting{met->first, met->second, o + met->first * d};
}

bool blocked(const std::vector<Solid>& solids, const std::vector<int>& which, const Vector3f& origin, const Vector3f& direction, float distance) {
    return std::any_of(which.begin(), which.end(), [&](int i) {
        const auto met = meet_on_way(solids[static_cast<std::size_t>(i)], origin, direction);
        return met && met->distance < distance;
    });
}

/// Rays from points within `width` of `origin`, in directions that leave `direction` by at most `spread` (m per m).
struct RayBundle {
    Vector3f origin, direction;
    float width, spread;

    /// Spheres around the solids decide, and a twentieth to spare: better one too many than a hole in a shadow.
    void meet(const std::vector<Solid>& solids, float length, std::vector<int>& which) const {
        which.clear();
        for (std::size_t i = 0; i < solids.size(); ++i) {
            const Vector3f to = solids[i].centre - origin;
            const float along = to.dot(direction), size = 1.05f * solids[i].half.norm() + width;
            if (along < -size || along > length + size) continue;
            const float reach = size + spread * std::max(along, 0.0f);
            if ((to - along * direction).squaredNorm() > reach * reach) continue;
            which.push_back(static_cast<int>(i));
        }
    }
};

}  // namespace

MovingSolids::MovingSolids(const std::vector<Solid>& moving, const std::vector<Lamp>& lamps)
    : solids(moving), all(moving.size()), shading(lamps.size()), shading_solid(moving.size() * lamps.size()) {
    std::iota(all.begin(), all.end(), 0);
    take_all();
    auto which = shading_solid.begin();
    for (std::size_t s = 0; s < moving.size(); ++s) {
        for (const Lamp& lamp : lamps) {
            const Vector3f to = lamp.position - moving[s].centre;
            const float distance = to.norm();
            const RayBundle bundle{moving[s].centre, to / distance, std::max(moving[s].half.norm(), lamp.radius) + 0.003f, 0};
            bundle.meet(moving, distance, *which);
            std::erase(*which, static_cast<int>(s));  // none of our solids stands in its own light
            ++which;
        }
    }
}

void MovingSolids::take_all() {
    in_view = mirrored = all;
    std::fill(shading.begin(), shading.end(), all);
    walls = true;
}

bool MovingSolids::none() const {
    return in_view.empty() && mirrored.empty() && std::all_of(shading.begin(), shading.end(), [](const std::vector<int>& which) { return which.empty(); });
}

RayTracer::RayTracer(const Scene& scene) : scene_(scene), furniture_(scene.furniture.size()) {
    std::iota(furniture_.begin(), furniture_.end(), 0);
    for (const WallPanel& wall : scene.walls) {
        const Vector2f along = wall.to - wall.from;
        wall_x_.push_back(wall.from.x());
        wall_y_.push_back(wall.from.y());
        wall_normal_x_.push_back(-along.y());
        wall_normal_y_.push_back(along.x());
    }
    for (const Lamp& lamp : scene.lamps) {
        lamp_x_.push_back(lamp.position.x());
        lamp_y_.push_back(lamp.position.y());
        lamp_z_.push_back(lamp.position.z());
        lamp_radius_.push_back(lamp.radius);
        lamp_power_.push_back(lamp.power);
    }
    const std::size_t filled = (scene.lamps.size() + 3) / 4 * 4;
    for (std::vector<float>* values : {&lamp_x_, &lamp_y_, &lamp_z_, &lamp_radius_, &lamp_power_}) values->resize(filled, 0.0f);
    for (std::uint64_t i = 0; i < lamp_points; ++i) {
        const double number = static_cast<double>(i), radius = std::sqrt((number + 0.5) / lamp_points),
                     angle = number * std::numbers::pi * (3 - std::sqrt(5.0));  // as a sunflower's seeds
        disc_.push_back(Eigen::Vector2d(radius * std::cos(angle), radius * std::sin(angle)).cast<float>());
    }
}

void RayTracer::narrow(const Vector3f& origin, const std::array<Vector3f, 4>& directions, MovingSolids& moving) const {
    moving.take_all();
    Vector3f middle = Vector3f::Zero();
    bool downward = true;
    for (const Vector3f& d : directions) {
        if (d.isZero()) return;
        downward &= d.z() < -1e-3f * d.norm();
        middle += d.normalized();
    }
    middle.normalize();
    constexpr float spare = 1e-3f;  // m, and m per m
    RayBundle bundle{origin, middle, spare, spare};
    for (const Vector3f& d : directions) bundle.spread = std::max(bundle.spread, 1.05f * (d / d.dot(middle) - middle).norm());
    bundle.meet(moving.solids, 1e30f, moving.in_view);
    if (!downward) return;
    const auto on_floor = [&](const Vector3f& d) { return Vector3f(origin - d * (origin.z() / d.z())); };
    const Vector3f place = on_floor(middle);
    float around = 0;
    for (const Vector3f& d : directions) around = std::max(around, 1.05f * (on_floor(d) - place).norm());
    const RayBundle mirrored{place, {middle.x(), middle.y(), -middle.z()}, around + spare, bundle.spread};
    mirrored.meet(moving.solids, 1e30f, moving.mirrored);
    for (std::size_t i = 0; i < scene_.lamps.size(); ++i) {
        const Lamp& lamp = scene_.lamps[i];
        const Vector3f to = lamp.position - place;
        const float distance = to.norm();
        const RayBundle shading{place, to / distance, std::max(around, lamp.radius) + 3 * spare, 0};
        shading.meet(moving.solids, distance, moving.shading[i]);
    }
}

void RayTracer::meet_walls(const Vector3f& o, const Vector3f& d, Hit& hit) const {
    const std::size_t count = scene_.walls.size();
    std::array<float, at_once> approach, distance;
    for (std::size_t start = 0; start < count; start += at_once) {
        const std::size_t part = std::min(at_once, count - start);
        for (std::size_t k = 0; k < part; ++k) {
            const std::size_t i = start + k;
            approach[k] = wall_normal_x_[i] * d.x() + wall_normal_y_[i] * d.y();
            distance[k] = (wall_normal_x_[i] * (wall_x_[i] - o.x()) + wall_normal_y_[i] * (wall_y_[i] - o.y())) / approach[k];
        }
        for (std::size_t k = 0; k < part; ++k) {
            if (!(distance[k] >= nearest && distance[k] < hit.distance) || std::abs(approach[k]) < 1e-9f) continue;
            const std::size_t i = start + k;
            const WallPanel& wall = scene_.walls[i];
            const Vector2f along = wall.to - wall.from;
            const Vector3f p = o + distance[k] * d;
            const float u = along.dot(p.head<2>() - wall.from) / along.squaredNorm();
            if (u < 0 || u > 1 || p.z() < 0 || p.z() > wall.height) continue;
            Vector3f n(wall_normal_x_[i], wall_normal_y_[i], 0);
            n.normalize();
            hit = {distance[k], approach[k] > 0 ? Vector3f(-n) : n, p, &wall.material, first_wall_surface + static_cast<int>(i) * 2 + (p.z() < wall.skirting)};
        }
    }
}

RayTracer::Hit RayTracer::first_solid(const MovingSolids& moving, const std::vector<int>& which, bool walls, const Vector3f& origin,
                                      const Vector3f& direction) const {
    Hit hit;
    if (walls) meet_walls(origin, direction, hit);
    const auto meet_solids = [&](const std::vector<Solid>& solids, const std::vector<int>& numbers, int first_surface) {
        for (const int i : numbers) {
            const Solid& s = solids[static_cast<std::size_t>(i)];
            const auto met = meet_on_way(s, origin, direction);
            if (!met || met->distance >= hit.distance) continue;
            const Vector3f& n = met->normal;
            const bool top = std::abs(n.z()) > 0.5f;
            const int face = top ? 0 : (s.round ? 1 : 1 + (std::abs(n.x()) > 0.5f ? (n.x() > 0) : 2 + (n.y() > 0)));
            hit = {met->distance, turned(n, s.axis.x(), -s.axis.y()), met->place, top ? &s.top : &s.side, first_surface + i * 8 + face};
        }
    };
    meet_solids(scene_.furniture, furniture_, first_furniture_surface);
    meet_solids(moving.solids, which, first_moving_surface);
    return hit;
}

Illumination RayTracer::illuminate(const MovingSolids& moving, const Sight& sight, std::uint64_t jitter, const KnownLamps& known) const {
    if (sight.face == 0) return {};
    const Vector3f &p = sight.place, &n = sight.normal;
    Illumination sum{scene_.ambient, 0};
    const Vector2f on_disc = disc_[jitter % lamp_points];
    const std::size_t count = scene_.lamps.size();
    std::array<float, at_once> x, y, z, distance, cosine, arriving;
    for (std::size_t start = 0; start < count; start += at_once) {
        const std::size_t filled = std::min(at_once, lamp_x_.size() - start), part = std::min(at_once, count - start);
        for (std::size_t k = 0; k < filled; ++k) {
            const std::size_t i = start + k;
            const float to_x = lamp_x_[i] + lamp_radius_[i] * on_disc.x() - p.x(), to_y = lamp_y_[i] + lamp_radius_[i] * on_disc.y() - p.y();
            const float to_z = lamp_z_[i] - p.z();
            distance[k] = std::sqrt(to_x * to_x + to_y * to_y + to_z * to_z);
            const float closeness = 1 / distance[k];
            x[k] = to_x * closeness;
            y[k] = to_y * closeness;
            z[k] = to_z * closeness;
            cosine[k] = n.x() * x[k] + n.y() * y[k] + n.z() * z[k];
            arriving[k] = lamp_power_[i] * cosine[k] * z[k] * closeness * closeness;
        }
        for (std::size_t k = 0; k < part; ++k) {
            if (!(z[k] > 0 && cosine[k] > 0 && arriving[k] >= least_light)) continue;
            const std::size_t i = start + k;
            const std::vector<int>& shading = sight.floor        ? moving.shading[i]
                                              : sight.solid >= 0 ? moving.shading_solid[static_cast<std::size_t>(sight.solid) * count + i]
                                                                 : moving.all;
            const int bit = 1 << (i % lamp_bits);
            const bool alone = count <= lamp_bits;  // nobody shares its bit
            if (alone && (known.dark & bit)) continue;
            if (!(alone && (known.lit & bit)) && (!shading.empty() || !furniture_.empty())) {
                const Vector3f from = p + 1e-3f * n, direction(x[k], y[k], z[k]);
                if (blocked(moving.solids, shading, from, direction, distance[k]) || blocked(scene_.furniture, furniture_, from, direction, distance[k])) {
                    continue;
                }
            }
            sum.light += arriving[k];
            sum.lamps |= bit;
        }
    }
    return sum;
}

float RayTracer::floor_albedo(const Vector3f& p, int& tile) const {
    const TiledFloor& floor = scene_.floor;
    const float u = p.x() / floor.tile;
    const float v = p.y() / floor.tile;
    const float edge = 0.5f * floor.grout / floor.tile;
    const auto off_joint = [](float value) { return std::abs(value - std::floor(value + 0.5f)); };
    const bool grout = off_joint(u) < edge || off_joint(v) < edge;
    tile = grout ? 1 : 2;
    const float returned = floor.albedo * (1 - floor.reflection);
    if (grout) return returned * 0.45f;
    const int across = static_cast<int>(std::floor(u)), along = static_cast<int>(std::floor(v));
    const float tone = lattice_noise(across, along, 7, scene_.seed);
    tile += 3 + (across & 1023) * 1024 + (along & 1023);
    return returned * (1 + floor.variation * tone + floor.grain.grain * grain(p, floor.grain.grain_size, scene_.seed));
}

float RayTracer::surface_albedo(const Hit& hit) const {
    const Material& m = *hit.material;
    const float texture = m.grain > 0 ? m.grain * grain(hit.local, m.grain_size, scene_.seed + 17) : 0.0f;
    const bool skirting = hit.surface >= first_wall_surface && hit.surface < first_furniture_surface && (hit.surface & 1);
    return (skirting ? 0.3f : m.albedo) * (1 + texture);
}

Sight RayTracer::look(const MovingSolids& moving, const Vector3f& origin, const Vector3f& direction) const {
    const Hit hit = first_solid(moving, moving.in_view, moving.walls, origin, direction);
    const float to_floor = direction.z() < 0 ? -origin.z() / direction.z() : 1e30f;
    Sight sight;
    if (to_floor < hit.distance) {
        sight.floor = true;
        sight.place = origin + to_floor * direction;
        sight.albedo = floor_albedo(sight.place, sight.face);
        // The polished floor mirrors what stands on it, and the bright ceiling elsewhere.
        const Hit image = first_solid(moving, moving.mirrored, true, sight.place, {direction.x(), direction.y(), -direction.z()});
        sight.added = scene_.floor.reflection * (image.material ? image.material->albedo * (scene_.ambient + 0.25f) : 0.8f);
        if (image.surface >= first_moving_surface) sight.image = image.surface;
        return sight;
    }
    if (!hit.material) {
        sight.added = 0.5f;
        return sight;
    }
    sight.place = origin + hit.distance * direction;
    sight.normal = hit.normal;
    sight.albedo = surface_albedo(hit);
    sight.face = hit.surface;
    if (hit.surface >= first_moving_surface) sight.solid = (hit.surface - first_moving_surface) / 8;
    return sight;
}

}  // namespace roomfix
