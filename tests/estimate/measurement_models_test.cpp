// Every measurement model against automatic differentiation of an independent formula.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <unsupported/Eigen/AutoDiff>

#include "roomfix/base/random.hpp"
#include "roomfix/estimate/corner_model.hpp"
#include "roomfix/estimate/landmark_model.hpp"
#include "roomfix/estimate/motion.hpp"
#include "roomfix/estimate/pose_model.hpp"
#include "roomfix/estimate/range_model.hpp"
#include "roomfix/estimate/tag_model.hpp"
#include "roomfix/geometry/row_time.hpp"

namespace roomfix {
namespace {

// Unknowns: x, y, yaw, then six errors of a calibration, then three of a position.
constexpr int unknowns = 12;
using Dual = Eigen::AutoDiffScalar<Eigen::Matrix<double, unknowns, 1>>;
using Vector3 = Eigen::Matrix<Dual, 3, 1>;
using Matrix3 = Eigen::Matrix<Dual, 3, 3>;

struct Unknowns {
    Dual x, y, yaw;
    Vector3 moved, turned, place;
};

Unknowns at(const Pose2& pose) {
    Unknowns u{Dual(pose.x, unknowns, 0), Dual(pose.y, unknowns, 1), Dual(pose.yaw, unknowns, 2), {}, {}, {}};
    for (int i = 0; i < 3; ++i) {
        u.moved[i] = Dual(0, unknowns, 3 + i);
        u.turned[i] = Dual(0, unknowns, 6 + i);
        u.place[i] = Dual(0, unknowns, 9 + i);
    }
    return u;
}

Matrix3 about_z(const Dual& angle) {
    Matrix3 r;
    r << cos(angle), -sin(angle), Dual(0), sin(angle), cos(angle), Dual(0), Dual(0), Dual(0), Dual(1);
    return r;
}

/// Rotation by a vector near zero, to first order.
Matrix3 small_turn(const Vector3& v) {
    Matrix3 r;
    r << Dual(1), -v[2], v[1], v[2], Dual(1), -v[0], -v[1], v[0], Dual(1);
    return r;
}

Vector3 constant(const Eigen::Vector3d& v) { return v.cast<Dual>(); }

/// Brown-Conrady, written out once more.
Eigen::Matrix<Dual, 2, 1> pixel_of(const CameraModel& m, const Vector3& p) {
    const Dual x = p[0] / p[2], y = p[1] / p[2];
    const Dual r = x * x + y * y;
    const auto& k = m.distortion;
    const Dual radial = 1.0 + r * (k[0] + r * (k[1] + r * k[4]));
    return {m.fx * (x * radial + 2 * k[2] * x * y + k[3] * (r + 2.0 * x * x)) + m.cx, m.fy * (y * radial + k[2] * (r + 2.0 * y * y) + 2 * k[3] * x * y) + m.cy};
}

/// The model's derivative by a state, zero where it does not depend on it.
template <int Rows>
Eigen::Matrix<double, Rows, 1> column(const Linearised<Rows>& l, int state) {
    for (std::size_t k = 0; k < l.states.size(); ++k) {
        if (l.states[k] == state) return l.by_state.col(static_cast<Eigen::Index>(k));
    }
    return Eigen::Matrix<double, Rows, 1>::Zero();
}

template <int Rows>
void expect_derivatives(const Linearised<Rows>& l, const Belief& belief, const Eigen::Matrix<Dual, Rows, 1>& predicted, int calibration_source, SlowKind place,
                        int place_source) {
    const auto expect_column = [&](int state, int unknown, double unit) {
        for (int row = 0; row < Rows; ++row) {
            const double exact = predicted[row].derivatives()[unknown] * unit;
            EXPECT_NEAR(column(l, state)[row], exact, 1e-9 * (1 + std::abs(exact))) << "row " << row << ", unknown " << unknown;
        }
    };
    for (int i = 0; i < 3; ++i) expect_column(i, i, 1);
    for (int i = 0; i < 6; ++i) {
        if (const auto slow = find_slow(belief, SlowKind::calibration, calibration_source, i)) expect_column(*slow, 3 + i, 0.01);
    }
    for (int i = 0; i < 3; ++i) {
        if (const auto slow = find_slow(belief, place, place_source, i)) expect_column(*slow, 9 + i, 0.002);
    }
}

Matrix6d hundredths() { return 1e-4 * Matrix6d::Identity(); }

Belief somewhere(Random& random) {
    const Pose2 pose{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-3, 3)};
    return belief_at(pose, 0.01 * Eigen::Matrix3d::Identity(), 0.5, 0.5, {});
}

CameraOnRobot looking_up_askew() {
    CameraOnRobot camera;
    camera.model = make_camera_model(640, 480, 300, 305, 318, 243, {-0.2, 0.05, 0.001, -0.002, 0.003});
    camera.robot_from_camera.pose.linear() = exponential_rotation({0.1, -0.15, 0.6});
    camera.robot_from_camera.pose.translation() = Eigen::Vector3d(0.2, -0.1, 0.4);
    camera.robot_from_camera.covariance = hundredths();
    return camera;
}

TEST(MeasurementModels, LandmarkPixelsHaveTheDerivativesOfAnIndependentFormula) {
    Random random(1);
    const CameraOnRobot camera = looking_up_askew();
    const OnboardSource source = onboard_source(7, camera);
    for (int round = 0; round < 20; ++round) {
        Belief belief = somewhere(random);
        std::vector<Eigen::Vector3d> points;
        for (int i = 0; i < 3; ++i) points.emplace_back(belief.mean[0] + random.uniform(-0.5, 0.5), belief.mean[1] + random.uniform(-0.5, 0.5), 3);
        LandmarkObservation seen;
        for (int i = 0; i < 3; ++i) seen.points.push_back({{320, 240}, Eigen::Matrix2d::Identity()});
        const KnownLandmark landmark{4, &points, 0.002};
        add_slow_states(belief, landmark, source, {});
        const auto l = linearise_points<3>(belief, seen, landmark, source);
        ASSERT_TRUE(l);
        const Unknowns u = at(belief.pose());
        Eigen::Matrix<Dual, 6, 1> predicted;
        for (int i = 0; i < 3; ++i) {
            const Vector3 in_robot = about_z(-u.yaw) * (constant(points[static_cast<std::size_t>(i)]) + u.place - Vector3(u.x, u.y, Dual(0)));
            const Matrix3 mount = small_turn(u.turned) * camera.robot_from_camera.pose.linear().cast<Dual>();
            const Vector3 in_camera = mount.transpose() * (in_robot - constant(camera.robot_from_camera.pose.translation()) - u.moved);
            predicted.segment<2>(2 * i) = pixel_of(camera.model, in_camera);
        }
        expect_derivatives<6>(*l, belief, predicted, 7, SlowKind::landmark_place, 4);
        for (int i = 0; i < 6; ++i) EXPECT_NEAR(l->residual[i], (i % 2 ? 240 : 320) - predicted[i].value(), 1e-9);
    }
}

TEST(MeasurementModels, CornersHaveTheDerivativesOfAnIndependentFormula) {
    Random random(2);
    CameraOnRobot camera = looking_up_askew();
    const OnboardSource source = onboard_source(3, camera);
    for (int round = 0; round < 20; ++round) {
        Belief belief = somewhere(random);
        SiteCorner corner;
        corner.position = Eigen::Vector3d(-2, -3, 2.7);
        corner.yaw = random.uniform(-3, 3);
        corner.sigma = 0.002;
        CornerObservation seen;
        for (int i = 0; i < 3; ++i) ensure_slow(belief, {SlowKind::corner_place, 5, i, 1, 0});
        add_slow_states(belief, source, {});
        // Seen exactly as predicted: there the rotation's residual is its difference to first order.
        const Eigen::Matrix3d corner_from_map = Eigen::AngleAxisd(-corner.yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
        seen.view.corner_from_camera = corner_from_map * map_from_robot(belief.pose()).linear() * camera.robot_from_camera.pose.linear();
        const auto l = linearise_corner(belief, seen, corner, 5, source);
        ASSERT_TRUE(l);
        const Unknowns u = at(belief.pose());
        const Matrix3 turn = corner_from_map.cast<Dual>() * about_z(u.yaw) * small_turn(u.turned) * camera.robot_from_camera.pose.linear().cast<Dual>();
        const Matrix3 off = turn * seen.view.corner_from_camera.transpose().cast<Dual>();
        const Vector3 there =
            corner_from_map.cast<Dual>() * (Vector3(u.x, u.y, Dual(0)) + about_z(u.yaw) * (constant(camera.robot_from_camera.pose.translation()) + u.moved) -
                                            constant(corner.position) - u.place);
        Eigen::Matrix<Dual, 5, 1> predicted;
        predicted << off(2, 1), off(0, 2), off(1, 0), -there[0] / there[2], -there[1] / there[2];
        expect_derivatives<5>(*l, belief, predicted, 3, SlowKind::corner_place, 5);
    }
}

TEST(MeasurementModels, RangesHaveTheDerivativesOfAnIndependentFormula) {
    Random random(3);
    const Eigen::Vector3d receiver(0.2, -0.1, 0.5), beacon(3, 2, 2.5);
    for (int round = 0; round < 20; ++round) {
        const Belief belief = somewhere(random);
        const PredictedRange predicted = predict_range(belief.pose(), receiver, beacon);
        const Unknowns u = at(belief.pose());
        const Vector3 way = Vector3(u.x, u.y, Dual(0)) + about_z(u.yaw) * constant(receiver) - constant(beacon);
        const Dual range = sqrt(way[0] * way[0] + way[1] * way[1] + way[2] * way[2]);
        EXPECT_NEAR(predicted.range, range.value(), 1e-12);
        for (int i = 0; i < 3; ++i) EXPECT_NEAR(predicted.by_pose[i], range.derivatives()[i], 1e-12);
    }
}

TEST(MeasurementModels, TagsHaveTheDerivativesOfAnIndependentFormula) {
    Random random(4);
    View view;
    view.model = make_camera_model(640, 480, 500, 502, 322, 238, {-0.1, 0.02, 0.0005, -0.001, 0});
    view.map_from_camera.pose = looking_at({4, 0.5, 3}, {0, 0, 0});
    SiteRobot robot;
    robot.tag = Tag{3, 0.2};
    robot.robot_from_tag.linear() = exponential_rotation({0.05, -0.1, 1.2});
    robot.robot_from_tag.translation() = Eigen::Vector3d(0.1, 0.05, 0.6);
    for (int round = 0; round < 20; ++round) {
        const Belief belief = somewhere(random);
        FixedList<PointSighting, 4> seen;
        for (int i = 0; i < 4; ++i) seen.push_back({{320, 240}, Eigen::Matrix2d::Identity()});
        const auto l = linearise_tag(belief, seen, view, robot, {}, {});
        ASSERT_TRUE(l);
        const Unknowns u = at(belief.pose());
        const auto points = own_points(*robot.tag);
        Eigen::Matrix<Dual, 8, 1> predicted;
        for (int i = 0; i < 4; ++i) {
            const Vector3 in_map = Vector3(u.x, u.y, Dual(0)) + about_z(u.yaw) * constant(robot.robot_from_tag * points[static_cast<std::size_t>(i)]);
            const Eigen::Isometry3d camera_from_map = view.map_from_camera.pose.inverse();
            predicted.segment<2>(2 * i) = pixel_of(view.model, camera_from_map.linear().cast<Dual>() * in_map + constant(camera_from_map.translation()));
        }
        expect_derivatives<8>(*l, belief, predicted, 0, SlowKind::landmark_place, 0);
    }
}

/// `linearise(belief)` of a row that is exposed `late` s later: the prediction is that of the robot moved on, and has the derivatives by its velocity.
template <int Rows, class Linearise, class AtOnce>
void expect_moved_on(const Belief& belief, double late, const Linearise& linearise, const AtOnce& all_rows_at_once) {
    const auto l = linearise(belief);
    Belief later = belief;
    later.mean.head<3>() += late * belief.velocity();
    const auto there = all_rows_at_once(later);
    EXPECT_LT((l.residual - there.residual).norm(), 1e-9);
    EXPECT_GT((l.residual - all_rows_at_once(belief).residual).norm(), 1e-4);
    for (int i = 0; i < 3; ++i) {
        Eigen::Matrix<double, Rows, 1> column = Eigen::Matrix<double, Rows, 1>::Zero();
        for (std::size_t k = 0; k < l.states.size(); ++k) {
            if (l.states[k] == state_vx + i) column += l.by_state.col(static_cast<Eigen::Index>(k));
        }
        Belief faster = belief;
        constexpr double h = 1e-4;
        faster.mean[state_vx + i] += h;
        EXPECT_LT((linearise(faster).residual - l.residual + h * column).norm(), 1e-3 * h);
    }
}

TEST(MeasurementModels, ALaterRowShowsTheRobotFurtherOnItsWay) {
    Random random(5);
    Belief belief = somewhere(random);
    belief.mean.segment<3>(state_vx) = Eigen::Vector3d(1.1, -0.6, 0.8);
    constexpr double readout = 0.03;
    constexpr double row = 440;
    const double late = row_time(readout, 480, row);
    EXPECT_NEAR(late, 0.0125, 1e-3);

    PoseObservation pose;
    pose.late = late;
    expect_moved_on<3>(
        belief, late, [&](const Belief& b) { return linearise_pose(b, pose, {}); }, [&](const Belief& b) { return linearise_pose(b, PoseObservation(), {}); });

    OnboardSource rolling = onboard_source(7, looking_up_askew());
    OnboardSource still = rolling;
    rolling.readout = readout;
    std::vector<Eigen::Vector3d> points;
    LandmarkObservation seen;
    for (int i = 0; i < 3; ++i) {
        points.emplace_back(belief.mean[0] + 0.1 * i, belief.mean[1] - 0.05 * i * i, 3);
        seen.points.push_back({{320, row}, Eigen::Matrix2d::Identity()});
    }
    const KnownLandmark landmark{4, &points, 0.002};
    expect_moved_on<6>(
        belief, late, [&](const Belief& b) { return *linearise_points<3>(b, seen, landmark, rolling); },
        [&](const Belief& b) { return *linearise_points<3>(b, seen, landmark, still); });

    SiteCorner corner;
    corner.position = Eigen::Vector3d(-2, -3, 2.7);
    CornerObservation edges;
    edges.pixel = {320, static_cast<float>(row)};
    edges.view.corner_from_camera = map_from_robot(belief.pose()).linear() * rolling.camera.robot_from_camera.pose.linear();
    expect_moved_on<5>(
        belief, late, [&](const Belief& b) { return *linearise_corner(b, edges, corner, 5, rolling); },
        [&](const Belief& b) { return *linearise_corner(b, edges, corner, 5, still); });

    View view;
    view.model = make_camera_model(640, 480, 500, 502, 322, 238, {});
    view.map_from_camera.pose = looking_at({belief.mean[0] + 2, belief.mean[1], 3}, {belief.mean[0], belief.mean[1], 0});
    SiteRobot robot;
    robot.tag = Tag{3, 0.2};
    FixedList<PointSighting, 4> tag;
    for (int i = 0; i < 4; ++i) tag.push_back({{320, row}, Eigen::Matrix2d::Identity()});
    PoseSource camera;
    camera.readout = readout;
    expect_moved_on<8>(
        belief, late, [&](const Belief& b) { return *linearise_tag(b, tag, view, robot, camera, {}); },
        [&](const Belief& b) { return *linearise_tag(b, tag, view, robot, {}, {}); });
}

TEST(MeasurementModels, WhatWasLearnedOfTimesThatAreToldInOneWaySaysNothingOfAnother) {
    Belief belief = belief_at({1, 2, 0}, 1e-8 * Eigen::Matrix3d::Identity(), 1e-4, 1e-4, {});
    belief.mean[state_vx] = 2;
    const PoseSource camera;
    PoseObservation seen;
    seen.pose = {1.1, 2, 0};  // where it will be 0.05 s later
    seen.covariance = 1e-6 * Eigen::Matrix3d::Identity();
    seen.time_error = {0.05, 1};
    const auto spread = [&](const PoseObservation& o) {
        Belief prepared = belief;
        add_slow_states(prepared, o, camera);
        const Linearised<3> l = linearise_pose(prepared, o, camera);
        const double off = l.residual.x();
        const int last = l.states[l.states.size() - 1];
        const double by = l.by_state(0, static_cast<Eigen::Index>(l.states.size()) - 1);
        return std::pair{off, std::sqrt(by * by * prepared.covariance(last, last))};
    };
    EXPECT_NEAR(spread(seen).second, 0.1, 1e-6);  // m: 2 m/s for 0.05 s
    add_slow_states(belief, seen, camera);
    update(belief, linearise_pose(belief, seen, camera), {0, std::numeric_limits<double>::infinity(), -10});
    EXPECT_NEAR(belief.mean[0], 1, 1e-3);
    EXPECT_NEAR(spread(seen).first, 0, 1e-3);
    EXPECT_LT(spread(seen).second, 0.005);
    seen.time_error.way = 2;
    EXPECT_NEAR(spread(seen).first, 0.1, 1e-3);
    EXPECT_NEAR(spread(seen).second, 0.1, 1e-6);
    seen.time_error = {};
    add_slow_states(belief, seen, camera);
    EXPECT_FALSE(find_slow(belief, SlowKind::time_offset, camera.source, 0));
}

TEST(MeasurementModels, ABoxIsMeantToFaceTheNearestOfTheWaysThatLookTheSame) {
    Belief belief = belief_at({1, 2, 3.0}, 0.01 * Eigen::Matrix3d::Identity(), 0.1, 0.1, {});
    PoseObservation seen;
    seen.pose = {1.1, 2.1, 3.05 - std::numbers::pi};
    seen.like_turns = 2;
    const Linearised<3> l = linearise_pose(belief, seen, {});
    EXPECT_NEAR(l.residual.x(), 0.1, 1e-12);
    EXPECT_NEAR(l.residual.z(), 0.05, 1e-12);
}

/// The covariance after a prediction is F P F^T + Q with F the derivative of the predicted mean.
template <class Predict>
void expect_true_transition(const Belief& start, const Predict& predict_it) {
    Eigen::Matrix<double, core_states, core_states> by_state;
    constexpr double h = 1e-6;
    for (int i = 0; i < core_states; ++i) {
        Belief more = start, less = start;
        more.mean[i] += h;
        less.mean[i] -= h;
        predict_it(more);
        predict_it(less);
        by_state.col(i) = (more.mean - less.mean).head<core_states>() / (2 * h);
    }
    Belief exact = start;  // known exactly: what remains is the noise of the motion
    exact.covariance.topLeftCorner<core_states, core_states>().setZero();
    predict_it(exact);
    Belief moved = start;
    predict_it(moved);
    const Eigen::Matrix<double, core_states, core_states> before = start.covariance.topLeftCorner<core_states, core_states>();
    const Eigen::Matrix<double, core_states, core_states> after = moved.covariance.topLeftCorner<core_states, core_states>();
    const Eigen::Matrix<double, core_states, core_states> expected =
        by_state * before * by_state.transpose() + exact.covariance.topLeftCorner<core_states, core_states>();
    EXPECT_LT((after - expected).cwiseAbs().maxCoeff(), 1e-7);
}

TEST(Motion, PredictionsPropagateTheCovarianceByTheirTrueDerivative) {
    Random random(5);
    for (int round = 0; round < 20; ++round) {
        Belief belief = somewhere(random);
        for (int i = state_vx; i < core_states; ++i) belief.mean[i] = random.uniform(-0.5, 0.5);
        Eigen::Matrix<double, core_states, core_states> root;
        for (int i = 0; i < root.size(); ++i) root.data()[i] = random.uniform(-0.1, 0.1);
        belief.covariance.topLeftCorner<core_states, core_states>() = root * root.transpose();
        MotionModel model;
        for (const Drive drive : {Drive::unknown, Drive::holonomic, Drive::differential}) {
            model.drive = drive;
            expect_true_transition(belief, [&](Belief& b) { predict(b, 0.2, model); });
        }
        OdometryStep step{0.1, {random.uniform(-0.2, 0.2), random.uniform(-0.1, 0.1)}, random.uniform(-0.3, 0.3), {0.5, 0.1}, 0.3};
        expect_true_transition(belief, [&](Belief& b) { predict(b, step, OdometryNoise{}); });
    }
}

}  // namespace
}  // namespace roomfix
