#include "roomfix/simulate/scene.hpp"

#include <cmath>
#include <optional>

#include "roomfix/simulate/lattice_noise.hpp"

namespace roomfix {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;

constexpr float nearest = 1e-4f;
constexpr float least_light = 0.01f;  // of a lamp's, to count

struct Hit {
    float distance = 1e30f;
    Vector3f normal = Vector3f::UnitZ();
    Vector3f local = Vector3f::Zero();  // where on the surface, for its texture
    const Material* material = nullptr;
    int surface = 0;
};

/// Value noise in -1..1 with cells of the given size, smooth between them.
float grain(const Vector3f& p, float size, std::uint64_t seed) {
    const Vector3f q = p / size;
    const Vector3f base(std::floor(q.x()), std::floor(q.y()), std::floor(q.z()));
    const Vector3f f = q - base;
    float sum = 0;
    for (int corner = 0; corner < 8; ++corner) {
        const int dx = corner & 1;
        const int dy = (corner >> 1) & 1;
        const int dz = corner >> 2;
        const float weight = (dx ? f.x() : 1 - f.x()) * (dy ? f.y() : 1 - f.y()) * (dz ? f.z() : 1 - f.z());
        sum += weight * lattice_noise(std::lround(base.x()) + dx, std::lround(base.y()) + dy, std::lround(base.z()) + dz, seed);
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

void meet_solids(const std::vector<Solid>& solids, int first_surface, const Vector3f& origin, const Vector3f& direction, Hit& hit) {
    for (std::size_t i = 0; i < solids.size(); ++i) {
        const Solid& s = solids[i];
        const float cosine = s.axis.x();
        const float sine = s.axis.y();
        const Vector3f o = turned(origin - s.centre, cosine, sine);
        const Vector3f d = turned(direction, cosine, sine);
        const auto met = meet(s, o, d);
        if (!met || met->first >= hit.distance) continue;
        const Vector3f& n = met->second;
        const bool top = std::abs(n.z()) > 0.5f;
        const int face = top ? 0 : (s.round ? 1 : 1 + (std::abs(n.x()) > 0.5f ? (n.x() > 0) : 2 + (n.y() > 0)));
        hit = {met->first, turned(n, cosine, -sine), o + met->first * d, top ? &s.top : &s.side, first_surface + static_cast<int>(i) * 8 + face};
    }
}

bool blocked(const std::vector<Solid>& solids, const Vector3f& origin, const Vector3f& direction, float distance) {
    for (const Solid& s : solids) {
        // Far from the ray's vertical plane? Then it cannot cast a shadow here.
        const Vector3f to = s.centre - origin;
        const float along = to.dot(direction);
        const float reach = s.half.norm();
        if ((to - along * direction).squaredNorm() > reach * reach) continue;
        const float cosine = s.axis.x();
        const float sine = s.axis.y();
        const auto met = meet(s, turned(to, cosine, sine) * -1.0f, turned(direction, cosine, sine));
        if (met && met->first < distance) return true;
    }
    return false;
}

void meet_walls(const Scene& scene, const Vector3f& o, const Vector3f& d, Hit& hit) {
    for (std::size_t i = 0; i < scene.walls.size(); ++i) {
        const WallPanel& wall = scene.walls[i];
        const Vector2f along = wall.to - wall.from;
        const Vector2f normal(-along.y(), along.x());
        const float approach = normal.dot(d.head<2>());
        if (std::abs(approach) < 1e-9f) continue;
        const float distance = normal.dot(wall.from - o.head<2>()) / approach;
        if (distance < nearest || distance >= hit.distance) continue;
        const Vector3f p = o + distance * d;
        const float u = along.dot(p.head<2>() - wall.from) / along.squaredNorm();
        if (u < 0 || u > 1 || p.z() < 0 || p.z() > wall.height) continue;
        Vector3f n(normal.x(), normal.y(), 0);
        n.normalize();
        hit = {distance, approach > 0 ? Vector3f(-n) : n, p, &wall.material, 64 + static_cast<int>(i) * 2 + (p.z() < wall.skirting)};
    }
}

/// Light that reaches a point, and which lamps do.
float illumination(const Scene& scene, const std::vector<Solid>& moving, const Vector3f& p, const Vector3f& n, const Vector2f& jitter, int& lamps) {
    float light = scene.ambient;
    const float turn = 6.2831853f * jitter.y();
    const Vector3f on_disc = std::sqrt(jitter.x()) * Vector3f(std::cos(turn), std::sin(turn), 0);  // of a lamp of radius 1
    for (std::size_t i = 0; i < scene.lamps.size(); ++i) {
        const Lamp& lamp = scene.lamps[i];
        const Vector3f to = lamp.position + lamp.radius * on_disc - p;
        const float squared = to.squaredNorm();
        const float most = lamp.power * to.z();  // that could arrive, times the distance's cube
        if (most <= 0 || most * most < least_light * least_light * squared * squared * squared) continue;
        const float distance = std::sqrt(squared);
        const Vector3f direction = to / distance;
        const float cosine = n.dot(direction);
        if (cosine <= 0) continue;
        const float arriving = lamp.power * cosine * direction.z() / squared;
        if (arriving < least_light) continue;
        const Vector3f start = p + 1e-3f * n;
        if (blocked(moving, start, direction, distance) || blocked(scene.furniture, start, direction, distance)) continue;
        light += arriving;
        lamps |= 1 << (i % 16);
    }
    return light;
}

float floor_albedo(const Scene& scene, const Vector3f& p, int& surface) {
    const TiledFloor& floor = scene.floor;
    const float u = p.x() / floor.tile;
    const float v = p.y() / floor.tile;
    const float edge = 0.5f * floor.grout / floor.tile;
    const bool grout = std::abs(u - std::round(u)) < edge || std::abs(v - std::round(v)) < edge;
    surface = grout ? 1 : 2;
    if (grout) return floor.albedo * 0.45f;
    const float tone = lattice_noise(std::lround(std::floor(u)), std::lround(std::floor(v)), 7, scene.seed);
    surface += static_cast<int>(std::floor(u)) * 131 + static_cast<int>(std::floor(v)) * 7919;
    return floor.albedo * (1 + floor.variation * tone + floor.grain.grain * grain(p, floor.grain.grain_size, scene.seed));
}

float surface_albedo(const Scene& scene, const Hit& hit) {
    const Material& m = *hit.material;
    const float texture = m.grain > 0 ? m.grain * grain(hit.local, m.grain_size, scene.seed + 17) : 0.0f;
    const bool skirting = hit.surface >= 64 && hit.surface < (1 << 16) && (hit.surface & 1);
    return (skirting ? 0.3f : m.albedo) * (1 + texture);
}

Hit first_solid(const Scene& scene, const std::vector<Solid>& moving, const Vector3f& origin, const Vector3f& direction) {
    Hit hit;
    meet_walls(scene, origin, direction, hit);
    meet_solids(scene.furniture, 1 << 16, origin, direction, hit);
    meet_solids(moving, 1 << 20, origin, direction, hit);
    return hit;
}

}  // namespace

RayHit trace(const Scene& scene, const std::vector<Solid>& moving, const Vector3f& origin, const Vector3f& direction, const Vector2f& jitter) {
    const Hit hit = first_solid(scene, moving, origin, direction);
    const float to_floor = direction.z() < 0 ? -origin.z() / direction.z() : 1e30f;
    int lamps = 0;
    if (to_floor < hit.distance) {
        const Vector3f p = origin + to_floor * direction;
        int surface = 0;
        const float albedo = floor_albedo(scene, p, surface);
        const float light = illumination(scene, moving, p, Vector3f::UnitZ(), jitter, lamps);
        // The polished floor mirrors what stands on it, and the bright ceiling elsewhere.
        const Vector3f mirrored(direction.x(), direction.y(), -direction.z());
        const Hit image = first_solid(scene, moving, p, mirrored);
        const float seen = image.material ? image.material->albedo * (scene.ambient + 0.25f) : 0.8f;
        return {albedo * light * (1 - scene.floor.reflection) + scene.floor.reflection * seen,
                surface * 32 + lamps + (image.surface >= (1 << 20) ? image.surface : 0)};
    }
    if (!hit.material) return {0.5f, 0};
    const Vector3f p = origin + hit.distance * direction;
    const float light = illumination(scene, moving, p, hit.normal, jitter, lamps);
    return {surface_albedo(scene, hit) * light, hit.surface * 32 + lamps};
}

std::vector<Solid> robot_solids(const Shape& shape, const RobotLook& look, const Pose2& pose) {
    const Eigen::Vector3d half_nominal = half_size(shape);
    const Vector3f half = (half_nominal + 0.5 * look.size_error).cast<float>();
    const Material body{look.body, 0.05f, 0.03f};
    const Material top{look.top, 0.05f, 0.04f};
    const Material rubber{0.05f, 0.2f, 0.02f};
    const Eigen::Vector2f yaw(static_cast<float>(std::cos(pose.yaw)), static_cast<float>(std::sin(pose.yaw)));
    const auto place = [&](float x, float y, float z) -> Vector3f {
        return {static_cast<float>(pose.x) + yaw.x() * x - yaw.y() * y, static_cast<float>(pose.y) + yaw.y() * x + yaw.x() * y, z};
    };
    std::vector<Solid> solids;
    if (std::holds_alternative<Cylinder>(shape)) {
        solids.push_back({true, place(0, 0, half.z()), half, yaw, body, top});
        return solids;
    }
    const float height = 2 * half.z();
    const float track_top = 0.35f * height;
    const float track_half = 0.2f * half.y();
    solids.push_back({false, place(0, 0, 0.5f * (track_top + height)), {half.x(), half.y(), 0.5f * (height - track_top)}, yaw, body, top});
    for (const float side : {-1.0f, 1.0f}) {
        const float y = side * (half.y() - track_half);
        solids.push_back({false, place(0, y, 0.5f * track_top), {half.x(), track_half, 0.5f * track_top}, yaw, rubber, rubber});
        if (look.arms) {
            solids.push_back({false, place(half.x() + 0.03f, 0.5f * y, 0.45f * height), {0.03f, 0.02f, 0.02f}, yaw, rubber, rubber});
        }
    }
    // A panel on the deck and the undercarriage between the tracks.
    solids.push_back({false, place(-0.3f * half.x(), 0, height - 0.001f), {0.3f * half.x(), 0.5f * half.y(), 0.002f}, yaw, rubber, rubber});
    solids.push_back({false, place(0, 0, 0.6f * track_top), {0.95f * half.x(), half.y() - 2 * track_half, 0.4f * track_top}, yaw, rubber, rubber});
    return solids;
}

std::vector<WallPanel> panels_along(const std::vector<Polyline>& polylines, float height) {
    std::vector<WallPanel> panels;
    for (const auto& line : polylines) {
        for (std::size_t i = 1; i < line.size(); ++i) {
            panels.push_back({line[i - 1].cast<float>(), line[i].cast<float>(), height});
        }
    }
    return panels;
}

}  // namespace roomfix
