// The rays of a picture, traced through the lens once: at the pixels' corners, and between them.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "roomfix/geometry/camera_model.hpp"

namespace roomfix {

class PixelRays {
public:
    /// `rotation`: of the camera in the frame in which rays are wanted.
    explicit PixelRays(const CameraModel& camera, const Eigen::Matrix3d& rotation = Eigen::Matrix3d::Identity());

    /// At the pixels' corners, (width + 1) x (height + 1), row by row; not of unit length. Zero where the lens sees nothing.
    const std::vector<Eigen::Vector3f>& corners() const { return corners_; }
    /// The number of a pixel's upper left corner. The one below it is `stride()` farther.
    std::size_t corner(int x, int y) const { return static_cast<std::size_t>(y) * stride_ + static_cast<std::size_t>(x); }
    std::size_t stride() const { return stride_; }
    /// Through a place in a pixel, `right` and `down` of its upper left corner, 0 to 1. Zero where one of its corners has none.
    Eigen::Vector3f within(int x, int y, float right, float down) const {
        const Eigen::Vector3f* top = &corners_[corner(x, y)];
        const Eigen::Vector3f* bottom = top + stride_;
        if (top[0].isZero() || top[1].isZero() || bottom[0].isZero() || bottom[1].isZero()) return Eigen::Vector3f::Zero();
        return (1 - down) * ((1 - right) * top[0] + right * top[1]) + down * ((1 - right) * bottom[0] + right * bottom[1]);
    }

private:
    std::size_t stride_;
    std::vector<Eigen::Vector3f> corners_;
};

}  // namespace roomfix
