#include "roomfix/overhead/overhead_observer.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "count_allocations.hpp"
#include "roomfix/base/decompositions.hpp"
#include "roomfix/simulate/scenario.hpp"

namespace roomfix {
namespace {

/// The first aisle of the li2014 scenario, with its background learned once for all tests.
class Overhead : public ::testing::Test {
protected:
    static void SetUpTestSuite() {
        scenario = new Scenario(li2014_scenario(21));
        scenario->robots[0].look.top = 0.10f;
        renderer = new CameraRenderer(scenario->scene, scenario->cameras[0].truth, scenario->cameras[0].sensor, 77);
        BackgroundLearner learner;
        LumaImage frame;
        for (std::uint64_t i = 0; i < 24; ++i) {
            renderer->render({}, light_at(0.1 * static_cast<double>(i), 21), 5000 + i, frame);
            learner.add(frame);
        }
        background = new BackgroundModel(learner.learn());
    }
    static void TearDownTestSuite() {
        delete background;
        delete renderer;
        delete scenario;
    }

    static OverheadObserver observer(std::vector<SiteRobot> robots = scenario->site.robots) {
        OverheadObserver made(*fixed_view(scenario->site.cameras[0]), robots);
        made.set_background(*background);
        return made;
    }
    static std::vector<Solid> robot_at(const Pose2& pose) { return robot_solids(scenario->robots[0].robot.shape, scenario->robots[0].look, pose); }
    static LumaImage frame_of(const std::vector<Solid>& solids, double light = 1, std::uint64_t index = 1) {
        LumaImage frame;
        renderer->render(solids, light, index, frame);
        return frame;
    }

    static Scenario* scenario;
    static CameraRenderer* renderer;
    static BackgroundModel* background;
};
Scenario* Overhead::scenario = nullptr;
CameraRenderer* Overhead::renderer = nullptr;
BackgroundModel* Overhead::background = nullptr;

double distance(const Pose2& a, const Pose2& b) { return std::hypot(a.x - b.x, a.y - b.y); }

TEST_F(Overhead, FindsARobotWithItsYawAndAllPosesThatLookTheSame) {
    auto eye = observer();
    OverheadResult result;
    const Pose2 truth{6.0, 5.75, 0.4};
    eye.observe(frame_of(robot_at(truth)), result);
    ASSERT_EQ(result.observations.size(), 1U) << result.reason;
    const auto& o = result.observations[0];
    EXPECT_LT(distance(o.pose, truth), 0.02);
    EXPECT_LT(std::abs(std::remainder(o.pose.yaw - truth.yaw, std::numbers::pi / 2)), 0.02);
    ASSERT_EQ(o.hypotheses.size(), 4U) << "a square robot looks the same after each quarter turn";
    double weights = 0;
    double nearest = 10;
    for (const auto& h : o.hypotheses) {
        weights += h.weight;
        nearest = std::min(nearest, std::abs(wrap_angle(h.pose.yaw - truth.yaw)));
    }
    EXPECT_NEAR(weights, 1, 1e-12);
    EXPECT_LT(nearest, 0.02);
    EXPECT_GT(Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(o.covariance).eigenvalues()[0], 0) << "never zero";
}

TEST_F(Overhead, TellsTheSolidDescribedFromARobotThatIsOnlyAboutSoLarge) {
    const Pose2 truth{6.0, 5.75, 0.4};
    const Box described = std::get<Box>(scenario->robots[0].robot.shape);
    std::vector<Solid> tower = robot_solids(Box{described.length, described.width, 0.5 * described.height}, scenario->robots[0].look, truth);
    for (const Solid& solid : robot_solids(Box{0.5 * described.length, 0.5 * described.width, described.height}, scenario->robots[0].look, truth)) {
        tower.push_back(solid);
    }
    OverheadSettings easy;  // takes what an outline explains badly, too
    easy.least_score = 0.1;
    const auto exactness = [&](const std::vector<Solid>& solids) {
        OverheadObserver eye(*fixed_view(scenario->site.cameras[0]), scenario->site.robots, easy);
        eye.set_background(*background);
        OverheadResult result;
        eye.observe(frame_of(solids), result);
        EXPECT_EQ(result.observations.size(), 1U) << result.reason;
        return result.observations.empty() ? 0 : result.observations[0].exact;
    };
    EXPECT_GT(exactness(robot_at(truth)), 3);
    EXPECT_LT(exactness(tower), -1);
}

TEST_F(Overhead, LightMayChangeByFifteenPerCent) {
    OverheadResult result;
    const Pose2 truth{6.4, 5.6, 1.0};
    for (const double light : {0.85, 1.15}) {
        auto eye = observer();
        eye.observe(frame_of(robot_at(truth), light), result);
        ASSERT_EQ(result.observations.size(), 1U) << light << ": " << result.reason;
        EXPECT_LT(distance(result.observations[0].pose, truth), 0.03);
    }
}

TEST_F(Overhead, ABoxHasTwoPosesACylinderNoYaw) {
    OverheadResult result;
    auto boxes = observer({{"long", Box{0.8, 0.5, 0.5}}});
    boxes.observe(frame_of(robot_solids(Box{0.8, 0.5, 0.5}, {0.12f, 0.1f, false}, {6.2, 5.7, 0.7})), result);
    ASSERT_EQ(result.observations.size(), 1U) << result.reason;
    EXPECT_EQ(result.observations[0].hypotheses.size(), 2U);
    EXPECT_LT(std::abs(std::remainder(result.observations[0].pose.yaw - 0.7, std::numbers::pi)), 0.05);
    auto cylinders = observer({{"can", Cylinder{0.5, 0.6}}});
    cylinders.observe(frame_of(robot_solids(Cylinder{0.5, 0.6}, {0.12f, 0.1f, false}, {6.2, 5.7, 0})), result);
    ASSERT_EQ(result.observations.size(), 1U) << result.reason;
    EXPECT_FALSE(result.observations[0].yaw_known);
    EXPECT_LT(distance(result.observations[0].pose, {6.2, 5.7, 0}), 0.03);
}

TEST_F(Overhead, NoRobotIsSaidWithTheReason) {
    auto eye = observer();
    OverheadResult result;
    eye.observe(frame_of({}), result);
    EXPECT_TRUE(result.observations.empty());
    EXPECT_NE(result.reason.find("nothing differs"), std::string::npos) << result.reason;
}

TEST_F(Overhead, AHardShadowAloneIsNotARobot) {
    // A board under the lamp, above the picture: only its shadow is on the floor.
    Solid board{false, {6.6f, 5.7f, 2.5f}, {0.14f, 0.14f, 0.01f}};
    auto eye = observer();
    OverheadResult result;
    eye.observe(frame_of({board}), result);
    for (const auto& o : result.observations) ADD_FAILURE() << "a robot at " << o.pose.x << ", " << o.pose.y << " support " << o.support;
}

TEST_F(Overhead, SomethingThatFillsTheViewIsSaidToDoSo) {
    auto eye = observer();
    OverheadResult result;
    // A checked blanket in front of the lens.
    LumaImage blanket(640, 480);
    for (int y = 0; y < 480; ++y) {
        for (int x = 0; x < 640; ++x) blanket.row(y)[x] = static_cast<std::uint8_t>((x / 90 + y / 70) % 2 ? 200 : 40);
    }
    eye.observe(blanket, result);
    EXPECT_TRUE(result.observations.empty());
    EXPECT_NE(result.reason.find("at once"), std::string::npos) << result.reason;
}

TEST_F(Overhead, TwoRobotsAreTwoAndKeepTheirNames) {
    OverheadResult result;
    auto eye = observer({{"r1", Box{0.54, 0.54, 0.45}}, {"tall", Box{0.40, 0.40, 0.90}}});
    auto solids = robot_at({5.6, 5.4, 0.3});
    const auto tall = robot_solids(Box{0.40, 0.40, 0.90}, {0.12f, 0.1f, false}, {7.0, 6.0, 0.1});
    solids.insert(solids.end(), tall.begin(), tall.end());
    eye.observe(frame_of(solids), result);
    ASSERT_EQ(result.observations.size(), 2U) << result.reason;
    for (const auto& o : result.observations) EXPECT_LT(distance(o.pose, o.robot == 0 ? Pose2{5.6, 5.4, 0} : Pose2{7.0, 6.0, 0}), 0.06);
}

TEST_F(Overhead, NoAllocationPerFrameInSteadyState) {
    if (!counts_allocations) GTEST_SKIP() << "not in a sanitized build";
    auto eye = observer();
    OverheadResult result;
    std::vector<LumaImage> frames;
    for (int i = 0; i < 6; ++i) frames.push_back(frame_of(robot_at({6.0 + 0.02 * i, 5.7, 0.3}), 1, 40 + static_cast<std::uint64_t>(i)));
    frames.push_back(frame_of(robot_at({4.4, 5.7, 0.3})));  // cut off by the image's border: the long way
    for (const auto& frame : frames) eye.observe(frame, result);
    const long before = allocations;
    for (int round = 0; round < 3; ++round) {
        for (const auto& frame : frames) eye.observe(frame, result);
    }
    EXPECT_EQ(allocations - before, 0);
    EXPECT_EQ(result.observations.size(), 1U);
}

}  // namespace
}  // namespace roomfix
