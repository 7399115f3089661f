#include "roomfix/evaluate/outline_bound.hpp"

#include <cmath>
#include <numbers>

#include "roomfix/base/decompositions.hpp"

namespace roomfix {

OutlineBound outline_bound(LumaView frame, LumaView background, const View& true_view, const ShapePoints& shape, const Pose2& truth,
                           const SensorModel& sensor) {
    OutlineBound bound;
    const Silhouette silhouette = project_silhouette(true_view, shape, truth);
    if (!silhouette.valid()) return bound;
    Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
    Eigen::Matrix<double, 3, 6> by_calibration = Eigen::Matrix<double, 3, 6>::Zero();
    for (int i = 0; i < silhouette.count; ++i) {
        const auto here = static_cast<std::size_t>(i);
        const auto next = static_cast<std::size_t>((i + 1) % silhouette.count);
        const Eigen::Vector3d from = body_point_map(shape, silhouette.indices[here], truth);
        const Eigen::Vector3d to = body_point_map(shape, silhouette.indices[next], truth);
        const int pixels = static_cast<int>((silhouette.corners[next] - silhouette.corners[here]).norm());
        for (int k = 0; k < pixels; ++k) {
            const Eigen::Vector3d p = from + (to - from) * ((k + 0.5) / pixels);
            ViewJacobian jacobian;
            const auto pixel = project_map_point(true_view, p, &jacobian);
            if (!pixel || !true_view.model.contains(*pixel, 5)) continue;
            const Eigen::Vector2d tangent = (jacobian.by_point * (to - from)).normalized();
            Eigen::Vector2d normal(tangent.y(), -tangent.x());
            if (normal.dot(*pixel - polygon_centroid(silhouette.polygon())) < 0) normal = -normal;
            const Eigen::Vector2d inside = *pixel - 2.5 * normal;
            const float x = static_cast<float>(inside.x());
            const float y = static_cast<float>(inside.y());
            const double grey = static_cast<double>(sample(frame, x, y));
            const double contrast = std::abs(grey - static_cast<double>(sample(background, x, y)));
            const double noise2 = sensor.read_noise * sensor.read_noise + sensor.shot_noise * grey;
            const double weight = contrast * contrast / (2 * std::sqrt(std::numbers::pi) * sensor.blur * noise2);
            const Eigen::RowVector3d along = normal.transpose() * jacobian.by_point;
            const Eigen::Vector3d by_pose(along.x(), along.y(), along.y() * (p.x() - truth.x) - along.x() * (p.y() - truth.y));
            information += weight * by_pose * by_pose.transpose();
            by_calibration += weight * by_pose * jacobian.by_calibration(true_view, Eigen::RowVector2d(normal.transpose()));
        }
    }
    if (information.determinant() <= 0) return bound;
    bound.pixels = information.inverse();
    const Eigen::Matrix<double, 3, 6> gain = bound.pixels * by_calibration;
    bound.with_calibration = bound.pixels + gain * gain.transpose();
    return bound;
}

}  // namespace roomfix
