// Pictures of a scene as a real camera would take them: lens, blur, gamma, light changes, noise, 8 bits.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "roomfix/geometry/view.hpp"
#include "roomfix/imaging/luma.hpp"
#include "roomfix/simulate/pixel_rays.hpp"
#include "roomfix/simulate/ray_tracer.hpp"
#include "roomfix/simulate/scene.hpp"
#include "roomfix/simulate/sensor.hpp"

namespace roomfix {

/// Renders one camera. The still parts are traced once; each frame traces only where robots and their shadows are.
class CameraRenderer {
public:
    /// `view` is the true pose; its covariance is not used.
    CameraRenderer(const Scene& scene, const View& view, const SensorModel& sensor, std::uint64_t seed);

    /// The frame with `moving` in the scene, its light multiplied by `gain`. `index` picks the noise: the same index
    /// gives the same bytes.
    void render(const std::vector<Solid>& moving, double gain, std::uint64_t index, LumaImage& frame) const;
    /// The same where rows are exposed one after another: `moving_at` says what is in the scene when a row is. Four rows are exposed at once.
    void render_rows(const std::function<std::vector<Solid>(double row)>& moving_at, double gain, std::uint64_t index, LumaImage& frame) const;

private:
    struct Rectangle {
        int left, top, right, bottom;  // inclusive
    };
    struct Cluster {
        Rectangle area;
        std::vector<Solid> solids;
    };
    Rectangle reach(const Solid& s) const;
    void find_clusters(const std::vector<Solid>& moving) const;
    Rectangle changed_by(const Cluster& cluster) const;
    void trace_cells(int row, const Rectangle& changed, MovingSolids& moving) const;
    void trace_cluster(const Cluster& cluster) const;
    void develop(double gain, std::uint64_t index, LumaImage& frame) const;
    /// Narrows `moving` to what matters to the square of `size` pixels below and right of (x, y). False where a grid cell looks as without it.
    bool narrow(int x, int y, int size, MovingSolids& moving) const;
    /// What the ray through a grid cell's middle meets, and which lamps reach that.
    struct Surface {
        int face = 0, image = 0, lamps = 0;
        bool operator==(const Surface&) const = default;
    };
    Surface surface_at(int x, int y, const MovingSolids& moving) const;
    void mark_changed(const Rectangle& area, MovingSolids& moving) const;
    /// Light that falls on a pixel's square: its mean, and the mean of it times the place in the square, px from the middle.
    struct PixelLight {
        float mean = 0, right = 0, down = 0;
    };
    struct Ray {
        Sight sight;
        Illumination falls;
        float light() const { return sight.albedo * falls.light + sight.added; }
    };
    static constexpr int cell_size = 4;  // px: one ray per grid cell finds out whether a robot or its shadow is there
    /// Rays of the pixels' corners in a grid cell. Those of its right side are the next cell's left side.
    struct CellCorners {
        std::array<Ray, (cell_size + 1) * (cell_size + 1)> rays;
        int next = -1;  // x at which that one would begin
    };
    Ray ray(std::uint64_t jitter, const Eigen::Vector3f& direction, const MovingSolids& moving) const;
    /// Traces the pixels of a grid cell within `area`. False where not all rays ended on the floor.
    bool trace_cell(int left, int top, const Rectangle& area, const MovingSolids& moving, CellCorners& corners, std::vector<PixelLight>& light) const;
    PixelLight edge_light(int x, int y, const std::array<const Ray*, 4>& corners, const MovingSolids& moving) const;
    void copy_still(const Rectangle& area) const;
    /// What the optics make of `light`, written to `blurred` within `area`.
    void blur(const std::vector<PixelLight>& light, const Rectangle& area, std::vector<float>& blurred) const;

    RayTracer tracer_;
    View view_;
    SensorModel sensor_;
    GammaCurve gamma_;
    std::uint64_t seed_;
    int width_, height_;
    int across_, down_;                   // grid cells
    PixelRays rays_;                      // map frame
    std::vector<PixelLight> still_;       // light without robots, before the blur
    std::vector<Surface> still_surface_;  // of each grid cell
    std::vector<char> still_floor_;       // whether nothing but floor is seen, per grid cell
    std::vector<float> still_blurred_;
    mutable std::vector<PixelLight> traced_;  // with robots, where they are; renders are not meant to run in two threads at once
    mutable std::vector<float> light_;        // the same, blurred
    mutable std::vector<char> changed_;       // per grid cell
    mutable std::vector<Cluster> clusters_;
};

}  // namespace roomfix
