// The pixels that a body covers at many poses near one, at a fraction of what each would cost by itself.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "roomfix/overhead/body.hpp"

namespace roomfix {

/// Of one camera. Around each corner of the body the lens is taken as linear; perspective stays exact.
class NearOutlines {
public:
    /// Around a pose, for a picture that is `scale` times smaller than the camera's. `radius`: of the body.
    void prepare(const View& view, const std::vector<ConvexPart>& parts, const Pose2& pose, int scale, double radius);
    /// Is a pose so near that the outline is the same to a fraction of a pixel?
    bool reach(const Pose2& pose) const;
    /// As roomfix::cover().
    void cover(const Pose2& pose, int width, int height, int row_step, BodyMask& mask) const;

private:
    struct Corner {
        Eigen::Vector2d place;   // m, robot frame
        Eigen::Vector3d offset;  // m, camera frame: what does not depend on the pose
        Eigen::Vector2d ray;     // (x/z, y/z) at the pose that was prepared
        Eigen::Vector2d pixel;   // there, px of the small picture
        Eigen::Matrix2d by_ray;  // px
    };
    Pose2 pose_;
    double radius_ = 0;  // m
    bool valid_ = false;
    Eigen::Matrix<double, 3, 2> camera_from_floor_;
    std::vector<Corner> corners_;
    std::vector<std::size_t> ends_;  // of each part's corners
};

/// Rows of the small picture from a body's foot to its top; nothing where one of them has no pixel.
std::optional<double> upright_rows(const View& view, const Body& body, const Pose2& pose, int scale);

/// A body's outlines in one camera.
struct NearBody {
    NearOutlines core;
    NearOutlines parts;
    bool unhidden = false;  // by walls, at all poses within reach
    double rows = 0;        // of the small picture, from its foot to its top

    /// `walls`: null: none.
    void prepare(const View& view, const std::vector<Polyline>* walls, const Body& body, const Pose2& pose, int scale);
};

}  // namespace roomfix
