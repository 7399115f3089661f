#include "roomfix/simulate/pixel_rays.hpp"

#include <Eigen/Geometry>

namespace roomfix {

PixelRays::PixelRays(const CameraModel& camera, const Eigen::Matrix3d& rotation) : stride_(static_cast<std::size_t>(camera.width) + 1) {
    corners_.reserve(stride_ * (static_cast<std::size_t>(camera.height) + 1));
    for (int y = 0; y <= camera.height; ++y) {
        std::optional<Eigen::Vector2d> ray;
        for (int x = 0; x <= camera.width; ++x) {
            ray = unproject_beside(camera, {x - 0.5, y - 0.5}, ray);
            corners_.emplace_back(Eigen::Vector3f::Zero());
            if (ray) corners_.back() = (rotation * ray->homogeneous()).cast<float>();
        }
    }
}

}  // namespace roomfix
