// A ceiling as a camera on a robot sees it: tiles, lamps that glare, LEDs on black panels. Map frame, metres; light 1 is a white
// surface in full light.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "roomfix/ceiling/floor_fit.hpp"
#include "roomfix/imaging/luma.hpp"
#include "roomfix/simulate/row_poses.hpp"
#include "roomfix/simulate/sensor.hpp"
#include "roomfix/site/site.hpp"

namespace roomfix {

/// A rectangle on the ceiling: a tube that shines, a dark panel, a duct.
struct CeilingPatch {
    Eigen::Vector2d centre = Eigen::Vector2d::Zero();
    Eigen::Vector2d half = Eigen::Vector2d::Zero();
    double yaw = 0;
    float light = 0;
};

/// A disc that shines: a landmark's LED, a downlight, a smoke detector's LED.
struct CeilingDisc {
    Eigen::Vector2d centre = Eigen::Vector2d::Zero();
    double radius = 0.0025;
    float light = 0;
};

struct CeilingScene {
    double height = 3;
    double tile = 0.60;
    float tile_light = 0.10f;           // in the camera's short exposure
    float grain = 0.04f;                // relative
    float rail_light = 0.16f;           // of the rails between tiles
    std::vector<CeilingPatch> patches;  // later ones lie over earlier ones
    std::vector<CeilingDisc> discs;
    std::uint64_t seed = 1;
};

/// How a landmark of LEDs looks.
struct LandmarkLook {
    double margin = 0.04;  // m, of the black panel around the LEDs
    float panel_light = 0.012f;
    double led_radius = 0.0025;  // m
    float led_light = 45;
    bool dead[3] = {false, false, false};  // right angle, end of leg a, end of leg b
};
/// Adds a landmark of LEDs as it really hangs there.
void add_landmark(const SiteLandmark& landmark, const LandmarkLook& look, CeilingScene& scene);

class CeilingRenderer {
public:
    CeilingRenderer(const CameraModel& model, const SensorModel& sensor, const GlareModel& glare, std::uint64_t seed);

    /// The frame that a camera at `map_from_camera` takes. `index` picks the noise: the same index gives the same bytes.
    void render(const CeilingScene& scene, const RowPoses& map_from_camera, double gain, std::uint64_t index, LumaImage& frame);

    /// The same without noise and rounding, grey levels row by row; above 255 where the sensor saturates.
    const std::vector<float>& expose(const CeilingScene& scene, const RowPoses& map_from_camera, double gain);

private:
    void trace(const CeilingScene& scene, const RowPoses& map_from_camera);
    void add_discs(const CeilingScene& scene, const RowPoses& map_from_camera);
    void add_point(const CeilingDisc& disc, const Eigen::Vector3d& point, const RowPoses& map_from_camera);

    CameraModel model_;
    Sensor sensor_;
    int width_, height_;
    std::vector<Eigen::Vector3f> rays_;  // 2 x 2 per pixel, camera frame, z = 1; z = 0 where the lens sees nothing
    std::vector<float> light_;           // row by row
};

}  // namespace roomfix
