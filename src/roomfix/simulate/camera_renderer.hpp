// Pictures of a scene as a real camera would take them: lens, blur, gamma, light changes, noise, 8 bits.
#pragma once

#include <cstdint>
#include <vector>

#include "roomfix/geometry/view.hpp"
#include "roomfix/imaging/luma.hpp"
#include "roomfix/simulate/pixel_rays.hpp"
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
    void trace_cluster(const Cluster& cluster) const;
    RayHit centre_ray(int x, int y, const std::vector<Solid>& moving) const;
    void mark_changed(const Rectangle& area, const std::vector<Solid>& moving) const;
    /// Light that falls on a pixel's square: its mean, and the mean of it times the place in the square, px from the middle.
    struct PixelLight {
        float mean = 0, right = 0, down = 0;
    };
    PixelLight traced(int x, int y, const std::vector<Solid>& moving) const;
    void copy_still(const Rectangle& area) const;
    /// What the optics make of `light`, written to `blurred` within `area`.
    void blur(const std::vector<PixelLight>& light, const Rectangle& area, std::vector<float>& blurred) const;

    Scene scene_;
    View view_;
    SensorModel sensor_;
    std::uint64_t seed_;
    int width_, height_;
    PixelRays rays_;                  // map frame
    std::vector<PixelLight> still_;   // light without robots, before the blur
    std::vector<int> still_surface_;  // what the ray through each grid cell's middle meets
    std::vector<float> still_blurred_;
    mutable std::vector<PixelLight> traced_;  // with robots, where they are; renders are not meant to run in two threads at once
    mutable std::vector<float> light_;        // the same, blurred
    mutable std::vector<char> changed_;       // per grid cell
    mutable std::vector<Cluster> clusters_;
};

}  // namespace roomfix
