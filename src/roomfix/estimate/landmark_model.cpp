#include "roomfix/estimate/landmark_model.hpp"

#include "roomfix/estimate/iterated_update.hpp"
#include "roomfix/estimate/pose_model.hpp"
#include "roomfix/estimate/time_error_model.hpp"
#include "roomfix/geometry/row_time.hpp"

namespace roomfix {

OnboardSource onboard_source(int source, const CameraOnRobot& camera) {
    OnboardSource made{source, camera};
    if (camera.robot_from_camera.covariance.trace() > 1e-12 || camera.intrinsics.any()) made.calibration = calibration_root(camera);
    return made;
}

void add_slow_states(Belief& belief, const OnboardSource& source, const TimeError& error) {
    add_time_error(belief, source.source, source.time_offset_sigma, error);
    for (int i = 0; i < 6; ++i) {
        if (source.calibration.col(i).squaredNorm() > 1e-12) ensure_slow(belief, {SlowKind::calibration, source.source, i, 1, 1e-4});
    }
}

void add_slow_states(Belief& belief, const KnownLandmark& landmark, const OnboardSource& source, const TimeError& error, int directions) {
    add_slow_states(belief, source, error);
    for (int i = 0; i < directions; ++i) ensure_slow(belief, {SlowKind::landmark_place, landmark.number, i, 1, 1e-5});
}

template <int Points>
std::optional<Linearised<2 * Points>> linearise_points(const Belief& belief, const LandmarkObservation& seen, const KnownLandmark& landmark,
                                                       const OnboardSource& source) {
    Linearised<2 * Points> l;
    Eigen::Matrix<double, 2 * Points, 3> by_pose, by_velocity;
    Eigen::Matrix<double, 2 * Points, camera_errors> by_camera;
    Eigen::Matrix<double, 2 * Points, 3> by_place;
    for (int i = 0; i < Points; ++i) {
        const auto k = static_cast<std::size_t>(i);
        SeenPointJacobian j;
        const double late = row_time(source.readout, source.camera.model.height, seen.points[k].pixel.y());
        const auto pixel = predict_point(source.camera, moved(belief, late), (*landmark.points)[k], &j);
        if (!pixel) return std::nullopt;
        l.residual.template segment<2>(2 * i) = seen.points[k].pixel - *pixel;
        l.noise.template block<2, 2>(2 * i, 2 * i) = seen.points[k].covariance;
        by_pose.template middleRows<2>(2 * i) = j.by_pose;
        by_velocity.template middleRows<2>(2 * i) = late * j.by_pose;
        by_camera.template middleRows<2>(2 * i) << j.by_mount, j.by_intrinsics;
        by_place.template middleRows<2>(2 * i) = j.by_point;
    }
    for (int i = 0; i < 3; ++i) l.depends(i, by_pose.col(i));
    for (int i = 0; i < 3 && source.readout > 0; ++i) l.depends(state_vx + i, by_velocity.col(i));
    depends_on_time<2 * Points>(l, belief, source.source, source.time_offset_sigma, seen.time_error, by_pose * belief.velocity());
    for (int i = 0; i < 3; ++i) {
        const Eigen::Matrix<double, 2 * Points, 1> column = landmark.sigma * by_place.col(i);
        l.depends_on_error(belief, SlowKind::landmark_place, landmark.number, i, column);
    }
    for (int i = 0; i < 6; ++i) {
        const auto slow = find_slow(belief, SlowKind::calibration, source.source, i);
        if (!slow) continue;
        const Eigen::Matrix<double, 2 * Points, 1> column = by_camera * source.calibration.col(i);
        l.depends_on_slow(belief, *slow, column);
    }
    return l;
}

template std::optional<Linearised<6>> linearise_points<3>(const Belief&, const LandmarkObservation&, const KnownLandmark&, const OnboardSource&);
template std::optional<Linearised<8>> linearise_points<4>(const Belief&, const LandmarkObservation&, const KnownLandmark&, const OnboardSource&);

std::optional<Innovation> update_landmark(Belief& belief, const LandmarkObservation& seen, const KnownLandmark& landmark, const OnboardSource& source,
                                          const OutlierModel& outliers) {
    const std::size_t count = landmark.points->size();
    if (seen.points.size() != count) return std::nullopt;
    add_slow_states(belief, landmark, source, seen.time_error);
    if (count == 3) return iterated_update<6>(belief, outliers, [&](const Belief& at) { return linearise_points<3>(at, seen, landmark, source); });
    if (count == 4) return iterated_update<8>(belief, outliers, [&](const Belief& at) { return linearise_points<4>(at, seen, landmark, source); });
    return std::nullopt;
}

}  // namespace roomfix
