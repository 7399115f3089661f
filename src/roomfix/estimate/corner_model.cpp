#include "roomfix/estimate/corner_model.hpp"

#include "roomfix/estimate/iterated_update.hpp"
#include "roomfix/estimate/pose_model.hpp"
#include "roomfix/estimate/time_error_model.hpp"
#include "roomfix/geometry/row_time.hpp"

namespace roomfix {

void add_slow_states(Belief& belief, int number, const OnboardSource& source, const TimeError& error) {
    add_slow_states(belief, source, error);
    for (int i = 0; i < 3; ++i) ensure_slow(belief, {SlowKind::corner_place, number, i, 1, 1e-5});
}

std::optional<Linearised<5>> linearise_corner(const Belief& belief, const CornerObservation& seen, const SiteCorner& corner, int number,
                                              const OnboardSource& source) {
    const double late = row_time(source.readout, source.camera.model.height, static_cast<double>(seen.pixel.y()));
    const Pose2 pose = moved(belief, late);
    const Eigen::Isometry3d& mount = source.camera.robot_from_camera.pose;
    const Eigen::Matrix3d corner_from_map = Eigen::AngleAxisd(-corner.yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    const Eigen::Matrix3d map_from_robot_turn = Eigen::AngleAxisd(pose.yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    const Eigen::Matrix3d corner_from_robot = corner_from_map * map_from_robot_turn;
    const Eigen::Vector3d arm = map_from_robot_turn * mount.translation();
    const Eigen::Vector3d at = corner_from_map * (Eigen::Vector3d(pose.x, pose.y, 0) + arm - corner.position);
    const double below = -at.z();
    if (below < 1e-3) return std::nullopt;
    const Eigen::Vector2d place = at.head<2>() / below;

    Linearised<5> l;
    l.residual.head<3>() = rotation_vector(seen.view.corner_from_camera * (corner_from_robot * mount.linear()).transpose());
    l.residual.tail<2>() = seen.view.place - place;
    // The place by a move of the camera in the corner's frame.
    Eigen::Matrix<double, 2, 3> by_move;
    by_move << Eigen::Matrix2d::Identity() / below, place / below;
    l.noise = seen.covariance;
    Vector5d column = Vector5d::Zero();
    for (int i = 0; i < 2; ++i) {
        column.tail<2>() = by_move * corner_from_map.col(i);
        l.depends(i, column);
    }
    column << 0, 0, 1, by_move * corner_from_map * Eigen::Vector3d::UnitZ().cross(arm);
    l.depends(state_yaw, column);
    for (int i = 0; i < 3 && late != 0; ++i) {
        column = late * l.by_state.col(i);
        l.depends(state_vx + i, column);
    }
    depends_on_time<5>(l, belief, source.source, source.time_offset_sigma, seen.time_error, l.by_state.leftCols<3>() * belief.velocity());

    for (int i = 0; i < 3; ++i) {
        column.head<3>().setZero();
        column.tail<2>() = -by_move * corner_from_map.col(i) * corner.sigma;
        l.depends_on_error(belief, SlowKind::corner_place, number, i, column);
    }
    Eigen::Matrix<double, 5, 6> by_mount = Eigen::Matrix<double, 5, 6>::Zero();
    by_mount.bottomLeftCorner<2, 3>() = by_move * corner_from_robot;
    by_mount.topRightCorner<3, 3>() = corner_from_robot;
    for (int i = 0; i < 6; ++i) {
        const auto slow = find_slow(belief, SlowKind::calibration, source.source, i);
        if (!slow) continue;
        column = by_mount * source.calibration.col(i).head<6>() - seen.by_intrinsics * source.calibration.col(i).tail<most_intrinsics>();
        l.depends_on_slow(belief, *slow, column);
    }
    return l;
}

std::optional<Innovation> update_corner(Belief& belief, const CornerObservation& seen, const SiteCorner& corner, int number, const OnboardSource& source,
                                        const OutlierModel& outliers) {
    add_slow_states(belief, number, source, seen.time_error);
    return iterated_update<5>(belief, outliers, [&](const Belief& at) { return linearise_corner(at, seen, corner, number, source); });
}

}  // namespace roomfix
