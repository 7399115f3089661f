#include "roomfix/estimate/tag_model.hpp"

#include "roomfix/estimate/time_error_model.hpp"
#include "roomfix/geometry/row_time.hpp"

namespace roomfix {

std::optional<Linearised<8>> linearise_tag(const Belief& belief, const FixedList<PointSighting, 4>& seen, const View& view, const SiteRobot& robot,
                                           const PoseSource& source, const TimeError& error) {
    if (!robot.tag || seen.size() != 4) return std::nullopt;
    const auto points = own_points(*robot.tag);
    Linearised<8> l;
    Eigen::Matrix<double, 8, 3> by_pose, by_velocity;
    Eigen::Matrix<double, 8, 6> by_calibration;
    for (int i = 0; i < 4; ++i) {
        const auto k = static_cast<std::size_t>(i);
        const double late = row_time(source.readout, view.model.height, seen[k].pixel.y());
        const Eigen::Isometry3d map_from_robot_now = map_from_robot(moved(belief, late));
        const Eigen::Vector3d arm = map_from_robot_now.linear() * (robot.robot_from_tag * points[k]);
        ViewJacobian j;
        const auto pixel = project_map_point(view, map_from_robot_now.translation() + arm, &j);
        if (!pixel) return std::nullopt;
        l.residual.segment<2>(2 * i) = seen[k].pixel - *pixel;
        l.noise.block<2, 2>(2 * i, 2 * i) = seen[k].covariance;
        by_pose.block<2, 2>(2 * i, 0) = j.by_point.leftCols<2>();
        by_pose.block<2, 1>(2 * i, 2) = j.by_point * Eigen::Vector3d::UnitZ().cross(arm);
        by_velocity.middleRows<2>(2 * i) = late * by_pose.middleRows<2>(2 * i);
        by_calibration.middleRows<2>(2 * i) = j.by_calibration(view, Eigen::Matrix2d::Identity());
    }
    for (int i = 0; i < 3; ++i) l.depends(i, by_pose.col(i));
    for (int i = 0; i < 3 && source.readout > 0; ++i) l.depends(state_vx + i, by_velocity.col(i));
    depends_on_time<8>(l, belief, source.source, source.time_offset_sigma, error, by_pose * belief.velocity());
    for (int i = 0; i < 6; ++i) {
        const Eigen::Matrix<double, 8, 1> column = by_calibration.col(i);
        l.depends_on_error(belief, SlowKind::calibration, source.source, i, column);
    }
    return l;
}

}  // namespace roomfix
