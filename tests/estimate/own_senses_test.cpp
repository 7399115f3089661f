// Robots that only have their own senses: wheels that err, ranges and bearings that err, and nobody who says by how much.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>
#include <vector>

#include "roomfix/base/decompositions.hpp"
#include "roomfix/base/random.hpp"
#include "roomfix/estimate/noise_search.hpp"
#include "roomfix/estimate/range_stretch.hpp"
#include "roomfix/estimate/robot_belief.hpp"
#include "roomfix/estimate/sighting_model.hpp"
#include "roomfix/estimate/tracker.hpp"

namespace roomfix {
namespace {

/// How a simulated robot's senses err.
struct Errors {
    double way = 1, turn = 1;  // true over measured
    double delay = 0;          // s: it moves so much later than its wheels say
    bool depth = false;        // ranges are depths along its front, not distances
};

constexpr double range_noise = 0.02;  // m

/// A room of 8 m x 6 m with marks along its walls.
Site walled_site() {
    Site site;
    SiteRobot robot;
    robot.id = "r1";
    robot.shape = Cylinder{0.3, 0.2};
    robot.drive = Drive::differential;
    robot.odometry = WheelOdometry{};
    Receiver receiver;
    receiver.position = {0, 0, 0.1};
    robot.receivers = {receiver};
    site.robots = {robot};
    for (const Eigen::Vector2d& place : {Eigen::Vector2d(0.3, 0),
                                         {3.1, -0.2},
                                         {5.2, 0.1},
                                         {8.1, 0.9},
                                         {7.9, 3.2},
                                         {8, 5.1},
                                         {6.1, 6.2},
                                         {4.4, 5.9},
                                         {1.2, 6},
                                         {-0.1, 4.6},
                                         {0, 2.9},
                                         {0.1, 1.2}}) {
        SiteBeacon beacon;
        beacon.id = "b" + std::to_string(site.beacons.size());
        beacon.position = {place.x(), place.y(), 0.1};
        site.beacons.push_back(beacon);
    }
    return site;
}

/// Around the room in wavy circles: 0.25 m/s, turning both ways.
struct TrueWay {
    std::vector<Pose2> poses;  // every 0.05 s
    Pose2 at(double t) const { return poses[std::min(static_cast<std::size_t>(std::max(t, 0.0) / 0.05 + 0.5), poses.size() - 1)]; }
};

TrueWay driven_for(double seconds) {
    TrueWay drive;
    Pose2 pose{3.5, 1.2, 0.3};
    constexpr int fine = 5;
    constexpr double step = 0.05 / fine;
    for (double t = 0; t < seconds;) {
        drive.poses.push_back(pose);
        for (int i = 0; i < fine; ++i, t += step) {
            pose.yaw += (0.12 + 0.5 * std::sin(0.35 * t)) * step;
            pose.x += 0.25 * std::cos(pose.yaw) * step;
            pose.y += 0.25 * std::sin(pose.yaw) * step;
        }
    }
    return drive;
}

struct Outcome {
    double rms = 0;   // m, over the last minute
    double nees = 0;  // per unknown, of the place
    int fixes = 0;
    TrackingModels learned;
};

Outcome drive_about(const Errors& errors, std::uint64_t seed) {
    constexpr double seconds = 240;
    const Site site = walled_site();
    Tracker tracker(site);
    Random random(seed);
    const TrueWay drive = driven_for(seconds);
    Pose2 wheels;
    double squares = 0, nees = 0;
    int fixes = 0;
    for (int i = 1; i < static_cast<int>(seconds / 0.05); ++i) {
        const double t = 0.05 * i;
        const Pose2 before = drive.at(t - 0.05 + errors.delay), now = drive.at(t + errors.delay);
        const double way = std::hypot(now.x - before.x, now.y - before.y), turned = wrap_angle(now.yaw - before.yaw);
        const double measured = way / errors.way + random.normal(0.002 * std::sqrt(way)),
                     turning = turned / errors.turn + random.normal(0.01 * std::sqrt(std::abs(turned)));
        wheels.x += measured * std::cos(wheels.yaw + 0.5 * turning);
        wheels.y += measured * std::sin(wheels.yaw + 0.5 * turning);
        wheels.yaw = wrap_angle(wheels.yaw + turning);
        tracker.observe({from_seconds(t), 0, wheels});
        if (i % 4 != 0) continue;
        const Pose2 pose = drive.at(t);
        const int beacon = random.index(static_cast<int>(site.beacons.size()));
        const Eigen::Vector2d to = site.beacons[static_cast<std::size_t>(beacon)].position.head<2>() - Eigen::Vector2d(pose.x, pose.y);
        const double bearing = wrap_angle(std::atan2(to.y(), to.x()) - pose.yaw);
        if (std::abs(bearing) > 0.6) continue;
        RangeObservation range;
        range.time = from_seconds(t);
        range.beacon = beacon;
        range.range = to.norm() * (errors.depth ? std::cos(bearing) : 1) + random.normal(range_noise);
        range.sigma = 0.05;
        tracker.observe(range);
        const auto fix = tracker.fix(0, range.time);
        if (t < seconds - 60 || !fix || fix->status == FixStatus::none) continue;
        const Eigen::Vector2d off(fix->pose.x - pose.x, fix->pose.y - pose.y);
        squares += off.squaredNorm();
        nees += 0.5 * off.dot(fix->covariance.topLeftCorner<2, 2>().ldlt().solve(off));
        ++fixes;
    }
    return {std::sqrt(squares / std::max(fixes, 1)), nees / std::max(fixes, 1), fixes, tracker.learned_models()};
}

TEST(OwnSenses, RangesOneByOneFindTheRobotAndHowItsWheelsErrIsLearned) {
    const Outcome outcome = drive_about({.way = 0.94, .turn = 0.92, .delay = 0.25}, 1);
    EXPECT_GT(outcome.fixes, 50);
    EXPECT_LT(outcome.rms, 0.1);
    EXPECT_LT(outcome.nees, 4);
    EXPECT_NEAR(outcome.learned.wheels[0].delay, 0.25, 0.1);
    EXPECT_EQ(outcome.learned.receiver(0).stretch.depth, 0);
}

/// Ranges of four beacons in turns, 28 a second and exact to 2 cm, from the first moment of a drive on a circle. The normalised square of the front's error at
/// the first fix.
double front_at_the_start(std::uint64_t seed) {
    Site site = walled_site();
    site.beacons.clear();
    for (const Eigen::Vector3d& place : {Eigen::Vector3d(0, 0, 2.5), {6, 0, 2.3}, {6, 5, 2.5}, {0, 5, 2.2}}) {
        site.beacons.push_back({"b" + std::to_string(site.beacons.size()), place});
    }
    Random random(seed);
    const double radius = random.uniform(0.8, 2), speed = random.uniform(0.3, 0.9), begin = random.uniform(0, 6.28);
    Tracker tracker(site);
    for (int i = 0; i < 300; ++i) {
        const double t = i / 28.0, angle = begin + speed / radius * t;
        const Pose2 pose{3 + radius * std::cos(angle), 2.5 + radius * std::sin(angle), angle + std::numbers::pi / 2};
        tracker.observe({from_seconds(t), 0, pose});
        RangeObservation range;
        range.time = from_seconds(t);
        range.beacon = i % 4;
        range.range =
            (site.beacons[static_cast<std::size_t>(range.beacon)].position - Eigen::Vector3d(pose.x, pose.y, 0.1)).norm() + random.normal(range_noise);
        range.sigma = range_noise;
        tracker.observe(range);
        const auto fix = tracker.fix(0, range.time);
        if (!fix || fix->status == FixStatus::none) continue;
        return std::pow(wrap_angle(fix->pose.yaw - pose.yaw), 2) / fix->covariance(2, 2);
    }
    ADD_FAILURE() << "it was not found in 10 s, seed " << seed;
    return 0;
}

TEST(OwnSenses, AFrontThatAShortWayCannotTellIsNotStated) {
    constexpr int drives = 16;
    double sum = 0;
    for (std::uint64_t seed = 1; seed <= drives; ++seed) sum += front_at_the_start(seed);
    EXPECT_LT(sum / drives, 2.7);  // chi squared of 16: once in 10000
}

TEST(OwnSenses, RangesThatAreDepthsAreNoticed) {
    const Outcome outcome = drive_about({.depth = true}, 2);
    EXPECT_GT(outcome.fixes, 50);
    EXPECT_LT(outcome.rms, 0.1);
    EXPECT_LT(outcome.nees, 4);
    EXPECT_EQ(outcome.learned.receiver(0).stretch.depth, 1);
}

/// Groups of two and three posts along the walls that all look alike, as a detector sees them that tells no names.
Site site_with_posts() {
    Site site = walled_site();
    site.beacons.clear();
    site.robots[0].receivers.clear();
    site.robots[0].detector = Detector{};
    for (const Eigen::Vector2d& post : {Eigen::Vector2d(1.2, 0),
                                        {1.35, 0.05},
                                        {5.5, 0.1},
                                        {5.6, -0.05},
                                        {5.75, 0},
                                        {8, 2.1},
                                        {8.1, 2.25},
                                        {6.3, 6},
                                        {6.45, 6.1},
                                        {2, 6.1},
                                        {2.15, 6},
                                        {2.3, 6.1},
                                        {0, 3.4},
                                        {-0.1, 3.55}}) {
        SiteLandmark landmark;
        landmark.id = "p" + std::to_string(site.landmarks.size());
        landmark.kind = PointMark{};
        landmark.map_from_landmark.translation() << post, 0.1;
        site.landmarks.push_back(landmark);
    }
    return site;
}

struct NamelessDrive {
    int fixes = 0;
    int wrong = 0;   // more than half a metre and four standard deviations off
    double rms = 0;  // m, over the last 20 s
};

/// What is seen ahead, without names, with depths for ranges that are 6 % too long; wheels that turn less than they say and tell it too early.
NamelessDrive drive_among_posts(std::uint64_t seed) {
    constexpr double seconds = 60;
    const Site site = site_with_posts();
    Tracker tracker(site);
    Random random(seed);
    const TrueWay drive = driven_for(seconds + 60);
    const double begin = random.uniform(0, 50);
    Pose2 wheels;
    NamelessDrive result;
    double squares = 0;
    int late = 0;
    for (int i = 1; i < static_cast<int>(seconds / 0.05); ++i) {
        const double t = 0.05 * i;
        const Pose2 told_before = drive.at(begin + t + 0.15), told = drive.at(begin + t + 0.2), now = drive.at(begin + t);
        const double way = std::hypot(told.x - told_before.x, told.y - told_before.y), turned = wrap_angle(told.yaw - told_before.yaw);
        const double turning = turned / 0.9 + random.normal(0.08 * std::sqrt(std::abs(turned)));
        wheels.x += way * std::cos(wheels.yaw + 0.5 * turning);
        wheels.y += way * std::sin(wheels.yaw + 0.5 * turning);
        wheels.yaw = wrap_angle(wheels.yaw + turning);
        tracker.observe({from_seconds(t), 0, wheels});
        if (i % 5 != 0) continue;
        for (const SiteLandmark& landmark : site.landmarks) {
            const Eigen::Vector2d to = landmark.map_from_landmark.translation().head<2>() - Eigen::Vector2d(now.x, now.y);
            const double bearing = wrap_angle(std::atan2(to.y(), to.x()) - now.yaw);
            if (std::abs(bearing) > 0.4 || random.uniform() < 0.5) continue;
            SightingObservation seen;
            seen.time = from_seconds(t);
            seen.range = (1.06 + random.normal(0.015)) * to.norm() * std::cos(bearing);
            seen.bearing = bearing + random.normal(0.01);
            tracker.observe(seen);
        }
        const auto fix = tracker.fix(0, from_seconds(t));
        if (!fix || fix->status == FixStatus::none) continue;
        ++result.fixes;
        const Eigen::Vector2d off(fix->pose.x - now.x, fix->pose.y - now.y);
        result.wrong += off.norm() > 0.5 && off.dot(fix->covariance.topLeftCorner<2, 2>().ldlt().solve(off)) > 16;
        if (t < seconds - 20) continue;
        squares += off.squaredNorm();
        ++late;
    }
    result.rms = std::sqrt(squares / std::max(late, 1));
    return result;
}

TEST(OwnSenses, PostsThatAllLookAlikeNeverPutItElsewhere) {
    int wrong = 0;
    for (std::uint64_t seed = 8; seed <= 9; ++seed) {
        const NamelessDrive drive = drive_among_posts(seed);
        std::printf("seed %d: %d fixes, %d wrong, %.3f m rms at the end\n", static_cast<int>(seed), drive.fixes, drive.wrong, drive.rms);
        EXPECT_GT(drive.fixes, 50) << "of 240, seed " << seed;
        EXPECT_LT(drive.rms, 0.2) << "seed " << seed;
        wrong += drive.wrong;
    }
    EXPECT_EQ(wrong, 0);
}

/// Derivative of `value` by each of the belief's states, by differences.
template <class Value>
Eigen::VectorXd derivatives(const Belief& belief, const Value& value) {
    constexpr double step = 1e-6;
    Eigen::VectorXd by_state(belief.size);
    for (int i = 0; i < belief.size; ++i) {
        Belief up = belief, down = belief;
        up.mean[i] += step;
        down.mean[i] -= step;
        by_state[i] = (value(up) - value(down)) / (2 * step);
    }
    return by_state;
}

Belief some_belief(Random& random) {
    Belief belief = belief_at({random.uniform(-2, 2), random.uniform(-2, 2), random.uniform(-3, 3)}, 0.01 * Eigen::Matrix3d::Identity(), 0.1, 0.1, {});
    return belief;
}

TEST(OwnSenses, SightingsAndRangesHaveTheirDerivatives) {
    Random random(3);
    DetectorSource detector;
    detector.position = {0.1, -0.05};
    detector.position_sigma = {0.05, 0.05};
    detector.range_common = detector.range_sway = 0.05;
    detector.bearing_common = detector.bearing_sway = 0.02;
    detector.stretch = {.depth = 1, .scale = 0.02, .direction = 0.1, .curve = 0.01};
    detector.bearing_shape = 0.05;
    RangeSource receiver;
    receiver.receiver = {0.1, 0.2, 0.3};
    receiver.receiver_sigma = {0.05, 0.05, 0.05};
    receiver.bias_sigma = receiver.sway_sigma = 0.1;
    receiver.stretch = detector.stretch;
    for (int trial = 0; trial < 50; ++trial) {
        Belief belief = some_belief(random);
        const Mark mark{{random.uniform(3, 6), random.uniform(3, 6)}};
        const Eigen::Vector3d beacon(mark.place.x(), mark.place.y(), 1);
        SightingObservation seen;
        seen.landmark = 0;
        seen.range = 4;
        seen.bearing = 0.3;
        seen.range_sigma = 0.05;
        seen.bearing_sigma = 0.01;
        add_slow_states(belief, seen, 0, detector);
        add_slow_states(belief, 0, receiver);
        for (int i = core_states; i < belief.size; ++i) belief.mean[i] = random.normal(0.05);
        for (const int row : {0, 1}) {
            const Eigen::VectorXd exact = derivatives(belief, [&](const Belief& b) { return -linearise_sighting(b, seen, 0, mark, detector).residual[row]; });
            const auto l = linearise_sighting(belief, seen, 0, mark, detector);
            Eigen::VectorXd stated = Eigen::VectorXd::Zero(belief.size);
            for (std::size_t k = 0; k < l.states.size(); ++k) stated[l.states[k]] += l.by_state(row, static_cast<Eigen::Index>(k));
            EXPECT_LT((exact - stated).cwiseAbs().maxCoeff(), 1e-6) << "row " << row;
        }
        const Eigen::VectorXd exact = derivatives(belief, [&](const Belief& b) { return predict_measured_range(b, b.pose(), 0, beacon, receiver).value; });
        const PredictedValue predicted = predict_measured_range(belief, belief.pose(), 0, beacon, receiver);
        Eigen::VectorXd stated = Eigen::VectorXd::Zero(belief.size);
        for (std::size_t k = 0; k < predicted.states.size(); ++k) stated[predicted.states[k]] += predicted.by_state[static_cast<Eigen::Index>(k)];
        EXPECT_LT((exact - stated).cwiseAbs().maxCoeff(), 1e-6);
    }
}

TEST(OwnSenses, ADepthIsHowFarAheadSomethingIs) {
    const Belief belief = belief_at({0, 0, 0}, Eigen::Matrix3d::Identity(), 1, 1, {});
    EXPECT_NEAR(stretched(belief, 0, {.depth = 1}, 2, 0.5).value, 2 * std::cos(0.5), 1e-12);
    EXPECT_NEAR(stretched(belief, 0, {}, 2, 0.5).value, 2, 1e-12);
    EXPECT_NEAR(grown(0.03, {.growth = 0.01}, 4), 0.05, 1e-12);
}

struct Moments {
    Eigen::VectorXd mean;
    Eigen::MatrixXd covariance;
};
Moments moments_of(const RobotBelief& robot) {
    const int size = robot.best().size;
    Moments m{Eigen::VectorXd::Zero(size), Eigen::MatrixXd::Zero(size, size)};
    for (const Hypothesis& h : robot.hypotheses) m.mean += std::exp(h.log_weight) * h.belief.mean.head(size);
    for (const Hypothesis& h : robot.hypotheses) {
        const Eigen::VectorXd off = h.belief.mean.head(size) - m.mean;
        m.covariance += std::exp(h.log_weight) * (h.belief.covariance.topLeftCorner(size, size) + off * off.transpose());
    }
    return m;
}

TEST(RobotBelief, VagueBeliefsAreSplitIntoNarrowOnesThatTogetherAreTheSame) {
    Random random(4);
    Belief vague = belief_at({1, 2, 0.3}, Eigen::Matrix3d::Identity(), 0.1, 0.1, {});
    Eigen::MatrixXd root(vague.size, vague.size);
    for (int i = 0; i < vague.size; ++i) {
        for (int j = 0; j < vague.size; ++j) root(i, j) = random.normal(0.2);
    }
    vague.covariance.topLeftCorner(vague.size, vague.size) = root * root.transpose();
    RobotBelief robot{{{vague, 0}}};
    const Moments before = moments_of(robot);
    const double sigma = std::sqrt(vague.covariance(state_yaw, state_yaw));
    split_vague(robot, 100, 0.5 * sigma);
    ASSERT_GT(robot.hypotheses.size(), 3u);
    double sum = 0;
    for (const Hypothesis& h : robot.hypotheses) {
        sum += std::exp(h.log_weight);
        EXPECT_LT(std::sqrt(h.belief.covariance(state_yaw, state_yaw)), 0.5 * sigma);
        const Eigen::MatrixXd p = h.belief.covariance.topLeftCorner(vague.size, vague.size);
        EXPECT_GT(symmetric_eigen(p).eigenvalues()[0], -1e-9);
    }
    EXPECT_NEAR(sum, 1, 1e-9);
    const Moments after = moments_of(robot);
    EXPECT_LT((after.mean - before.mean).cwiseAbs().maxCoeff(), 1e-9);
    EXPECT_LT((after.covariance - before.covariance).cwiseAbs().maxCoeff(), 1e-9);
    RobotBelief known{{{vague, 0}}};
    split_vague(known, 100, 2 * sigma);
    EXPECT_EQ(known.hypotheses.size(), 1u);
}

TEST(RobotBelief, HypothesesThatHaveBecomeTheSameAreJoinedWithTheirSpread) {
    Belief a = belief_at({1, 2, 0.3}, 0.04 * Eigen::Matrix3d::Identity(), 0.1, 0.1, {});
    Belief b = a;
    b.mean[0] += 0.1;
    RobotBelief robot{{{a, std::log(0.75)}, {b, std::log(0.25)}}};
    const Moments before = moments_of(robot);
    settle(robot);
    ASSERT_EQ(robot.hypotheses.size(), 1u);
    const Moments after = moments_of(robot);
    EXPECT_LT((after.mean - before.mean).cwiseAbs().maxCoeff(), 1e-12);
    EXPECT_LT((after.covariance - before.covariance).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(NoiseSearch, FindsHowLargeErrorsAreAndLeavesOutWhatExplainsNothing) {
    Random random(5);
    std::vector<double> errors;
    for (int i = 0; i < 400; ++i) errors.push_back(random.normal(0.15));
    SensedKinds kinds;
    kinds.ranges = true;
    kinds.range_sigma = 0.05;
    const NoiseSearch::Evidence evidence = [&](const SenseNoise& noise) {
        double sum = 0;
        const double sigma = noise.receiver.factor * kinds.range_sigma;
        for (const double e : errors) sum -= 0.5 * e * e / (sigma * sigma) + std::log(sigma);
        return sum;
    };
    const NoiseSearch search(kinds, std::nullopt, evidence);
    const auto found = search.best({});
    EXPECT_NEAR(found.noise.receiver.factor, 3, 0.35);
    EXPECT_EQ(found.noise.receiver.common, 0);
    EXPECT_EQ(found.noise.receiver.own, 0);
    EXPECT_EQ(found.noise.receiver.sway, 0);
    EXPECT_EQ(found.noise.receiver.stretch.depth, 0);
    EXPECT_EQ(found.noise.delay, 0);
    EXPECT_GE(search.widened(found).receiver.factor, found.noise.receiver.factor);
}

}  // namespace
}  // namespace roomfix
