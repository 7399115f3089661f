// Light along rays through a simulated room. Map frame, metres.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "roomfix/simulate/scene.hpp"

namespace roomfix {

/// What a ray meets.
struct Sight {
    Eigen::Vector3f place = Eigen::Vector3f::Zero();
    Eigen::Vector3f normal = Eigen::Vector3f::UnitZ();
    float albedo = 0;  // part of the light there that comes back along the ray
    float added = 0;   // light that comes whatever falls on the place: mirrored, or of what is beyond the scene
    int face = 0;      // of which solid, wall or tile; 0: of nothing
    int image = 0;     // which moving face the floor mirrors; 0: none
    bool floor = false;
    int solid = -1;  // which of the moving ones; -1: none

    bool same_faces(const Sight& other) const { return face == other.face && image == other.image; }
};

/// Light that falls on a place.
struct Illumination {
    float light = 0;
    int lamps = 0;  // which of them reach it: a bit each
};

/// What moves in the scene, and which of it a narrow bundle of rays may have to do with.
struct MovingSolids {
    const std::vector<Solid>& solids;
    std::vector<int> all;                         // their numbers
    std::vector<int> in_view;                     // that rays of the bundle may meet,
    std::vector<int> mirrored;                    // may meet once the floor has mirrored them,
    std::vector<std::vector<int>> shading;        // and that may stand between each lamp and what the bundle sees of the floor
    std::vector<std::vector<int>> shading_solid;  // that may stand between each lamp and each solid, solid by solid
    bool walls = true;                            // whether rays of the bundle may meet walls before the floor

    MovingSolids(const std::vector<Solid>& moving, const std::vector<Lamp>& lamps);
    /// Any of them, for all rays.
    void take_all();
    /// Whether the rays have nothing to do with any of them, as long as they end on the floor.
    bool none() const;
};

/// Lamps of which it is known that they reach a place, and that they do not: a bit each.
struct KnownLamps {
    int lit = 0, dark = 0;
};

/// A scene made ready for rays.
class RayTracer {
public:
    explicit RayTracer(const Scene& scene);
    /// Solids that move in this scene, all of them for all rays.
    MovingSolids with(const std::vector<Solid>& moving) const { return {moving, scene_.lamps}; }

    const Scene& scene() const { return scene_; }
    /// Follows the ray from `origin` along the unit vector `direction`. `moving` stands in the scene for this ray only.
    Sight look(const MovingSolids& moving, const Eigen::Vector3f& origin, const Eigen::Vector3f& direction) const;
    /// `jitter` modulo `lamp_points` picks the point of each lamp that decides the shadow; points that are numbered at even steps cover it evenly.
    static constexpr std::uint64_t lamp_points = 1024;
    Illumination illuminate(const MovingSolids& moving, const Sight& sight, std::uint64_t jitter, const KnownLamps& known = {}) const;
    /// Of the floor at a place, and which tile it is.
    float floor_albedo(const Eigen::Vector3f& place, int& tile) const;
    /// Finds those of `moving` that matter to the rays from `origin` between four directions (of any length). Where not all directions point to
    /// the floor, all matter for what is mirrored and shaded there; where one is zero, for everything.
    void narrow(const Eigen::Vector3f& origin, const std::array<Eigen::Vector3f, 4>& directions, MovingSolids& moving) const;

private:
    struct Hit;
    Hit first_solid(const MovingSolids& moving, const std::vector<int>& which, bool walls, const Eigen::Vector3f& origin,
                    const Eigen::Vector3f& direction) const;
    void meet_walls(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction, Hit& hit) const;
    float surface_albedo(const Hit& hit) const;

    Scene scene_;
    std::vector<int> furniture_;                                              // numbers of all of it
    std::vector<float> wall_x_, wall_y_, wall_normal_x_, wall_normal_y_;      // one end of each wall, and across it
    std::vector<float> lamp_x_, lamp_y_, lamp_z_, lamp_radius_, lamp_power_;  // each lamp's; dark ones fill up the last four
    std::vector<Eigen::Vector2f> disc_;                                       // points that cover a lamp of radius 1 evenly
};

}  // namespace roomfix
