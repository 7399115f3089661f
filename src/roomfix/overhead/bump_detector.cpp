#include "roomfix/overhead/bump_detector.hpp"

#include "roomfix/imaging/colour_image.hpp"

namespace roomfix {

BumpDetector::BumpDetector(const View& view, const BumpSettings& settings) : model_(view.model), settings_(settings) {}

/// How a pixel moves with a small turn of the camera (rad, about its axes) and with the picture's size around the principal point.
MotionJacobian BumpDetector::jacobian_at(const Eigen::Vector2d& pixel) const {
    MotionJacobian jacobian = MotionJacobian::Zero();
    const auto ray = unproject(model_, pixel);
    if (!ray) return jacobian;
    const Eigen::Vector3d point(ray->x(), ray->y(), 1);
    ProjectionJacobian by_point;
    if (!project(model_, point, &by_point)) return jacobian;
    Eigen::Matrix3d turn;  // a turned camera sees the point turned the other way
    turn << 0, -point.z(), point.y(), point.z(), 0, -point.x(), -point.y(), point.x(), 0;
    jacobian.leftCols<3>() = by_point * turn;
    jacobian.col(3) = pixel - Eigen::Vector2d(model_.cx, model_.cy);
    return jacobian;
}

void BumpDetector::set_reference(LumaView background) {
    PictureMotion prior = PictureMotion::Constant(settings_.most_turned);
    prior[3] = settings_.most_zoomed;
    alignment_.set_reference(
        background, [this](const Eigen::Vector2d& pixel) { return jacobian_at(pixel); }, prior);
    bumped_ = false;
    frames_ = 0;
}

bool BumpDetector::is_bumped(LumaView frame) {
    if (!has_reference()) return false;
    if (!bumped_ && frames_++ % settings_.every != 0) return false;
    found_ = alignment_.align(frame);
    const double limit = settings_.beyond * settings_.sway * colour_scale(frame.width);
    bumped_ = found_.nats > settings_.prior && found_.offset > limit;
    return bumped_;
}

}  // namespace roomfix
