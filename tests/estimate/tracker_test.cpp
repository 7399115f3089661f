#include "roomfix/estimate/tracker.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <functional>
#include <limits>
#include <numbers>

#include "roomfix/base/decompositions.hpp"
#include "roomfix/base/random.hpp"

namespace roomfix {
namespace {

SiteRobot robot_of(const char* id, const Shape& shape) {
    SiteRobot robot;
    robot.id = id;
    robot.shape = shape;
    return robot;
}

Site site_of(std::vector<SiteRobot> robots) {
    Site site;
    site.robots = std::move(robots);
    for (const double x : {0.0, 8.0}) {
        for (const double y : {0.0, 6.0}) {
            SiteBeacon beacon;
            beacon.position = Eigen::Vector3d(x, y, 2.5);
            site.beacons.push_back(beacon);
        }
    }
    return site;
}

PoseObservation seen(double x, double y, double yaw, double sigma = 0.01, int alike = 1, int robot = 0) {
    PoseObservation o;
    o.robot = robot;
    o.pose = {x, y, wrap_angle(yaw)};
    o.covariance = Eigen::Vector3d(sigma * sigma, sigma * sigma, 1e-4).asDiagonal();
    o.like_turns = alike;
    return o;
}

PoseObservation place(double x, double y, double sigma = 0.01, int robot = 0) {
    PoseObservation o = seen(x, y, 0, sigma, 1, robot);
    o.yaw_known = false;
    return o;
}

void see(Tracker& tracker, double t, const std::string& camera, const PoseObservation& o) { tracker.observe(from_seconds(t), camera, {&o, 1}); }

const Site box_site = site_of({robot_of("r1", Box{0.54, 0.54, 0.45})});

TEST(Tracker, FindsTheFrontOfASquareRobotByTheWayItDrives) {
    Tracker tracker(box_site);
    Random random(1);
    for (int i = 0; i < 60; ++i) {
        const double t = 0.1 * i;
        see(tracker, t, "hall", seen(1 + random.normal(0.01), 0.4 * t + random.normal(0.01), std::numbers::pi / 2 * random.index(4), 0.01, 4));
    }
    const auto fixes = tracker.fixes(from_seconds(5.9));
    ASSERT_EQ(fixes.size(), 1U);
    EXPECT_EQ(fixes[0].robot, "r1");
    EXPECT_NEAR(fixes[0].pose.x, 1, 0.02);
    EXPECT_NEAR(fixes[0].pose.y, 0.4 * 5.9, 0.03);
    EXPECT_NEAR(fixes[0].pose.yaw, std::numbers::pi / 2, 0.05);
}

TEST(Tracker, TellsTheHalfTurnOfABoxByItsWheels) {
    Tracker tracker(site_of({robot_of("r1", Box{0.6, 0.4, 0.4})}));
    // It drives backwards: only the wheels know.
    for (int i = 0; i < 60; ++i) {
        const double t = 0.1 * i;
        tracker.observe({from_seconds(t), 0, {-0.3 * t, 0, 0}});
        see(tracker, t, "hall", seen(5 - 0.3 * t, 2, std::numbers::pi, 0.01, 2));
    }
    const auto fixes = tracker.fixes(from_seconds(5.9));
    ASSERT_EQ(fixes.size(), 1U);
    EXPECT_NEAR(fixes[0].pose.yaw, 0, 0.05);
}

TEST(Tracker, CoastsWithGrowingUncertaintyThenSaysThatItDoesNotKnow) {
    Tracker tracker(site_of({robot_of("r1", Cylinder{0.5, 0.5})}));
    for (int i = 0; i < 20; ++i) see(tracker, 0.1 * i, "hall", place(0.05 * i, 0));
    const auto now = tracker.fixes(from_seconds(1.9)), later = tracker.fixes(from_seconds(2.7)), much_later = tracker.fixes(from_seconds(10));
    ASSERT_EQ(now.size(), 1U);
    EXPECT_EQ(now[0].status, FixStatus::ok);
    EXPECT_EQ(later[0].status, FixStatus::coasting);
    EXPECT_GT(later[0].covariance(0, 0), 10 * now[0].covariance(0, 0));
    EXPECT_EQ(much_later[0].status, FixStatus::none);
    EXPECT_NE(much_later[0].reason.find("not seen for 8.1 s"), std::string::npos) << much_later[0].reason;
}

/// Everything at once: a camera, another one that is late, ranges and wheels.
struct Told {
    double arrives;
    std::function<void(Tracker&)> tell;
};

std::vector<Told> a_drive(Random& random) {
    std::vector<Told> all;
    for (int i = 0; i < 400; ++i) {
        const double t = 5 + 0.02 * i;
        const Pose2 at{4 + 2 * std::cos(0.4 * t), 3 + 2 * std::sin(0.4 * t), wrap_angle(0.4 * t + std::numbers::pi / 2)};
        const auto arrives = [&] { return t + random.uniform(0, 0.9); };
        if (i % 5 == 0) {
            auto o = seen(at.x + random.normal(0.01), at.y + random.normal(0.01), at.yaw + random.normal(0.01), 0.01, 2);
            if (i % 45 == 0) o.pose.x += 3;  // an outlier
            all.push_back({arrives(), [=](Tracker& k) { see(k, t, i % 2 ? "a" : "b", o); }});
        }
        if (i % 3 == 0) {
            const int b = i % 4;
            const Eigen::Vector3d& beacon = box_site.beacons[static_cast<std::size_t>(b)].position;
            const double range = (Eigen::Vector3d(at.x, at.y, 0) - beacon).norm() + std::abs(random.normal(0.05));
            all.push_back({arrives(), [=](Tracker& k) { k.observe(RangeObservation{from_seconds(t), 0, b, range, 0.03}); }});
        }
        if (i % 4 == 1) all.push_back({arrives(), [=](Tracker& k) { k.observe({from_seconds(t), 0, at}); }});
    }
    return all;
}

TEST(Tracker, GivesTheSameWhateverTheOrderOfArrival) {
    Random random(3);
    for (int round = 0; round < 5; ++round) {
        const auto in_order = a_drive(random);
        auto shuffled = in_order;
        std::stable_sort(shuffled.begin(), shuffled.end(), [](const Told& a, const Told& b) { return a.arrives < b.arrives; });
        Tracker first(box_site), second(box_site);
        for (const Told& told : in_order) told.tell(first);
        for (const Told& told : shuffled) told.tell(second);
        EXPECT_EQ(second.counts().late, 0);
        const auto a = first.fixes(from_seconds(13)), b = second.fixes(from_seconds(13));
        ASSERT_EQ(a.size(), 1U);
        ASSERT_EQ(b.size(), 1U);
        EXPECT_NEAR(a[0].pose.x, b[0].pose.x, 1e-9);
        EXPECT_NEAR(a[0].pose.y, b[0].pose.y, 1e-9);
        EXPECT_NEAR(a[0].pose.yaw, b[0].pose.yaw, 1e-9);
        EXPECT_LT((a[0].covariance - b[0].covariance).cwiseAbs().maxCoeff(), 1e-9);
    }
}

TEST(Tracker, CanBeAskedForThePast) {
    Tracker tracker(box_site);
    for (int i = 0; i <= 40; ++i) see(tracker, 0.05 * i, "hall", seen(0.5 * 0.05 * i, 1, 0));
    const auto then = tracker.fixes(from_seconds(1.5));
    ASSERT_EQ(then.size(), 1U);
    EXPECT_NEAR(then[0].pose.x, 0.75, 0.01);
}

TEST(Tracker, CountsWhatItCannotUseAndGoesOn) {
    Tracker tracker(box_site);
    const double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
    for (int i = 0; i < 10; ++i) see(tracker, 5 + 0.1 * i, "hall", seen(1, 2, 0));
    const auto before = tracker.fixes(from_seconds(6));
    auto bad = seen(nan, 0, 0);
    see(tracker, 6, "hall", bad);
    bad = seen(1, infinity, 0);
    see(tracker, 6, "hall", bad);
    bad = seen(1, 2, 0);
    bad.covariance.setZero();
    see(tracker, 6, "hall", bad);
    bad.covariance = -Eigen::Matrix3d::Identity();
    see(tracker, 6, "hall", bad);
    see(tracker, 6, "hall", seen(1, 2, 0, 0.01, 1, 7));  // a robot unknown to the site
    tracker.observe(RangeObservation{from_seconds(6), 0, 0, nan, 0.1});
    tracker.observe(RangeObservation{from_seconds(6), 0, 0, 3, 0});
    tracker.observe(RangeObservation{from_seconds(6), 0, 0, 3, -1});
    tracker.observe(RangeObservation{from_seconds(6), 0, 0, -3, 0.1});
    tracker.observe(RangeObservation{from_seconds(6), 0, 99, 3, 0.1});
    tracker.observe(RangeDifferenceObservation{from_seconds(6), 0, {1, 1}, 3, 0.1});
    tracker.observe({from_seconds(6), 0, {nan, 0, 0}});
    tracker.observe({from_seconds(6), -1, {0, 0, 0}});
    EXPECT_EQ(tracker.counts().impossible, 13);
    const auto after = tracker.fixes(from_seconds(6));
    ASSERT_EQ(after.size(), 1U);
    EXPECT_EQ(after[0].pose.x, before[0].pose.x);
    EXPECT_EQ(after[0].covariance, before[0].covariance);
}

TEST(Tracker, CountsWhatComesTwiceOrTooLate) {
    Tracker tracker(box_site);
    for (int i = 0; i < 40; ++i) see(tracker, 5 + 0.1 * i, "hall", seen(1, 2, 0));
    see(tracker, 8.9, "hall", seen(1, 2, 0));
    see(tracker, 6.0, "door", seen(1, 2, 0));
    EXPECT_EQ(tracker.counts().twice, 1);
    EXPECT_EQ(tracker.counts().late, 1);
    EXPECT_EQ(tracker.counts().used, 40);
}

TEST(Tracker, TakesTwoObservationsOfTheSameInstant) {
    Tracker tracker(box_site);
    for (int i = 0; i < 20; ++i) {
        see(tracker, 0.1 * i, "hall", seen(1, 2, 0));
        see(tracker, 0.1 * i, "door", seen(1, 2, 0));
    }
    EXPECT_EQ(tracker.counts().used, 40);
    EXPECT_EQ(tracker.fixes(from_seconds(1.9))[0].sources.size(), 2U);
}

TEST(Tracker, OneTimeFarFromAllOthersIsAnErrorTwoAreAClockThatWasSet) {
    Tracker tracker(box_site);
    for (int i = 0; i < 10; ++i) see(tracker, 100 + 0.1 * i, "hall", seen(1, 2, 0));
    see(tracker, 100000, "hall", seen(1, 2, 0));
    see(tracker, 101, "hall", seen(1, 2, 0));
    EXPECT_EQ(tracker.counts().strayed, 1);
    EXPECT_EQ(tracker.fixes(from_seconds(101))[0].status, FixStatus::ok);
    for (int i = 0; i < 10; ++i) see(tracker, 20 + 0.1 * i, "hall", seen(3, 4, 0));
    EXPECT_EQ(tracker.counts().strayed, 2);
    const auto fixes = tracker.fixes(from_seconds(20.9));
    ASSERT_EQ(fixes.size(), 1U);
    EXPECT_NEAR(fixes[0].pose.x, 3, 0.01);
}

TEST(Tracker, FindsAKidnappedRobotAgainWithinTwoSeconds) {
    Tracker tracker(box_site);
    Random random(5);
    for (int i = 0; i < 50; ++i) see(tracker, 0.1 * i, "hall", seen(1 + random.normal(0.01), 2 + random.normal(0.01), 0));
    double found = -1;
    for (int i = 50; i < 80; ++i) {
        see(tracker, 0.1 * i, "hall", seen(6 + random.normal(0.01), 5 + random.normal(0.01), 1.5));
        const auto fixes = tracker.fixes(from_seconds(0.1 * i));
        if (found < 0 && fixes[0].status == FixStatus::ok && std::hypot(fixes[0].pose.x - 6, fixes[0].pose.y - 5) < 0.05) found = 0.1 * (i - 50);
    }
    EXPECT_GE(found, 0.3) << "a single wrong sighting must not move it";
    EXPECT_LE(found, 2);
}

/// A robot that stands and is seen for a second, then not for one: all that time cameras see the floor where it should be.
void vanish(Tracker& tracker, double nats) {
    for (int i = 0; i < 20; ++i) {
        const double t = 0.1 * i;
        tracker.observe({from_seconds(t), 0, {0, 0, 0}});
        if (i < 10) {
            see(tracker, t, "hall", seen(1, 2, 0));
        } else {
            tracker.observe(from_seconds(t), "hall", std::span<const PoseObservation>());
            tracker.observe(from_seconds(t), "hall", AbsenceObservation{0, {1, 2, 0}, nats});
        }
    }
}

TEST(Tracker, ARobotThatIsNotWhereItShouldBeHasNoFixAndIsBelievedAtOnceWhereItIsSeen) {
    for (const bool alike : {false, true}) {
        std::vector<SiteRobot> robots = {robot_of("r1", Box{0.54, 0.54, 0.45})};
        if (alike) robots.push_back(robot_of("r2", Box{0.54, 0.54, 0.45}));
        Tracker tracker(site_of(robots));
        vanish(tracker, -4);
        const auto fix = tracker.fix(0, from_seconds(1.9));
        ASSERT_TRUE(fix);
        EXPECT_EQ(fix->status, FixStatus::none);
        EXPECT_NE(fix->reason.find("although cameras see the place"), std::string::npos) << fix->reason;
        EXPECT_TRUE(tracker.expected(from_seconds(1.9)).empty()) << "it is looked for everywhere";
        for (int i = 20; i < (alike ? 45 : 22); ++i) {
            tracker.observe({from_seconds(0.1 * i), 0, {0, 0, 0}});
            see(tracker, 0.1 * i, "hall", seen(4, 5, 0));
        }
        const auto again = tracker.fixes(from_seconds(alike ? 4.4 : 2.1));
        ASSERT_FALSE(again.empty());
        EXPECT_EQ(again[0].status, FixStatus::ok);
        EXPECT_NEAR(again[0].pose.x, 4, 0.05);
    }
}

TEST(Tracker, ARobotThatCamerasMayJustNotSeeCoasts) {
    Tracker tracker(box_site);
    vanish(tracker, -1.5);  // it may be hidden
    EXPECT_EQ(tracker.fix(0, from_seconds(1.9))->status, FixStatus::coasting);
}

TEST(Tracker, OneFalseSightingMovesNothing) {
    Tracker tracker(box_site);
    for (int i = 0; i < 40; ++i) see(tracker, 0.1 * i, "hall", i == 30 ? seen(5, 5, 1) : seen(1 + 0.03 * i, 2, 0));
    EXPECT_NEAR(tracker.fixes(from_seconds(3.9))[0].pose.x, 1 + 0.03 * 39, 0.01);
}

TEST(Tracker, PutsASourceInQuarantineThatContradictsTheOthersAndTakesItBack) {
    Tracker tracker(box_site);
    Random random(6);
    const auto look = [&](int i, double off) {
        const double t = 0.1 * i, x = 1 + 0.02 * i;
        see(tracker, t, "hall", seen(x + random.normal(0.01), 2 + random.normal(0.01), 0));
        see(tracker, t + 0.05, "door", seen(x + 0.01 + off + random.normal(0.01), 2 + random.normal(0.01), 0));
        tracker.observe({from_seconds(t), 0, {x, 0, 0}});
        tracker.observe({from_seconds(t + 0.05), 0, {x + 0.01, 0, 0}});
    };
    for (int i = 0; i < 50; ++i) look(i, 0);
    EXPECT_TRUE(tracker.quarantines().empty());
    for (int i = 50; i < 120; ++i) look(i, 0.4);
    const auto bad = tracker.quarantines();
    ASSERT_EQ(bad.size(), 1U);
    EXPECT_EQ(bad[0].source, "door");
    EXPECT_NEAR(bad[0].distance, 0.4, 0.15);
    EXPECT_NEAR(tracker.fixes(from_seconds(11.9))[0].pose.x, 1 + 0.02 * 119, 0.03);
    for (int i = 120; i < 200; ++i) look(i, 0);
    EXPECT_TRUE(tracker.quarantines().empty());
}

/// A tracker that is told that a camera's clock may be off learns by how much; one that trusts it is off by speed times offset.
TEST(Tracker, LearnsHowFarACamerasTimeStampsAreOff) {
    const double late = 0.06;  // s: the stamps say so much more than is true
    const auto truth = [](double t) { return Pose2{4 + 2 * std::sin(0.5 * t), 3 + 2 * std::cos(0.5 * t), -0.5 * t}; };
    double errors[2] = {0, 0};
    for (const bool told : {false, true}) {
        Site site = site_of({robot_of("r1", Box{0.6, 0.4, 0.4})});
        SiteCamera camera;
        camera.id = "slow";
        camera.model = make_camera_model(640, 480, 500, 500, 320, 240);
        KnownPose known;
        known.map_from_camera.pose = looking_at({0, 0, 2.5}, {4, 3, 0});
        camera.placement.emplace<KnownPose>(known);
        camera.time_offset_sigma = told ? 0.1 : 0;
        site.cameras.push_back(camera);
        Tracker tracker(site);
        Random random(3);
        for (int i = 0; i < 400; ++i) {
            const double t = 0.05 * i;
            const bool slow = i % 2 == 1;
            const Pose2 at = truth(slow ? t - late : t);
            see(tracker, t, slow ? "slow" : "prompt", seen(at.x + random.normal(0.01), at.y + random.normal(0.01), at.yaw + random.normal(0.01)));
            if (i < 200) continue;
            const Fix fix = tracker.fixes(from_seconds(t)).at(0);
            errors[told] += std::hypot(fix.pose.x - truth(t).x, fix.pose.y - truth(t).y) / 200;
        }
        const auto index = find_slow(tracker.track(0)->belief.best(), SlowKind::time_offset, tracker.models().fixed.rbegin()->first - 1, 0);
        EXPECT_EQ(index.has_value(), told);
        EXPECT_NEAR(index ? camera.time_offset_sigma * tracker.track(0)->belief.best().mean[*index] : -late, -late, 0.015);
    }
    EXPECT_LT(errors[1], 0.5 * errors[0]);
}

TEST(Tracker, StartsAsUnsureAsTheTimeOfItsFirstPictureIs) {
    double squares = 0;
    constexpr int starts = 400;
    Random random(11);
    for (int i = 0; i < starts; ++i) {
        Tracker tracker(box_site);
        const double late = random.normal(0.05), vx = random.normal(0.7), vy = random.normal(0.7);
        PoseObservation first = seen(4 - late * vx + random.normal(0.01), 3 - late * vy + random.normal(0.01), 0);
        first.time_error = {0.05, 1};
        see(tracker, 1, "c", first);
        const Fix fix = tracker.fixes(from_seconds(1)).at(0);
        const Eigen::Vector2d off(fix.pose.x - 4, fix.pose.y - 3);
        squares += off.dot(fix.covariance.topLeftCorner<2, 2>().inverse() * off) / 2;
    }
    EXPECT_NEAR(squares / starts, 1, 0.25);
}

TEST(Tracker, ATagTellsWhichOfTwoLookAlikesItIsAndWhere) {
    std::vector<SiteRobot> robots = {robot_of("a1", Box{0.5, 0.5, 0.3}), robot_of("a2", Box{0.5, 0.5, 0.3})};
    for (int r = 0; r < 2; ++r) {
        robots[static_cast<std::size_t>(r)].tag = Tag{7 + r, 0.2};
        robots[static_cast<std::size_t>(r)].robot_from_tag.translation() = Eigen::Vector3d(0, 0, 0.3);
    }
    Site site = site_of(robots);
    SiteCamera camera;
    camera.id = "hall";
    camera.model = make_camera_model(640, 480, 500, 500, 320, 240);
    KnownPose known;
    known.map_from_camera.pose = looking_at({4, 0.5, 3}, {4, 3, 0});
    known.map_from_camera.covariance = 1e-8 * Matrix6d::Identity();
    camera.placement.emplace<KnownPose>(known);
    site.cameras.push_back(camera);
    Tracker tracker(site);
    Random random(4);
    const View view{camera.model, known.map_from_camera};
    const auto at = [](int r, double t) { return Pose2{3.2 + 1.5 * r, 2.5 + 0.1 * t, 0.3 - 0.2 * r}; };
    const auto tag_of = [&](int r, double t) {
        TagSighting tag{r, {}, {{at(r, t), 1e-3 * Eigen::Matrix3d::Identity(), true, 1}}};
        for (const Eigen::Vector3d& corner : own_points(*robots[static_cast<std::size_t>(r)].tag)) {
            const auto pixel = project_map_point(view, map_from_robot(at(r, t)) * (robots[static_cast<std::size_t>(r)].robot_from_tag * corner));
            tag.corners.push_back({*pixel + 0.1 * Eigen::Vector2d(random.normal(), random.normal()), 0.01 * Eigen::Matrix2d::Identity()});
        }
        return tag;
    };
    for (int i = 0; i < 40; ++i) {
        for (int r = 0; r < 2; ++r) tracker.observe(from_seconds(0.1 * i), "hall", tag_of(r, 0.1 * i));
    }
    for (int r = 0; r < 2; ++r) {
        const auto fix = tracker.fix(r, from_seconds(3.9));
        ASSERT_TRUE(fix) << r;
        EXPECT_LT(std::hypot(fix->pose.x - at(r, 3.9).x, fix->pose.y - at(r, 3.9).y), 0.005);
        EXPECT_NEAR(fix->pose.yaw, at(r, 3.9).yaw, 0.01);
        EXPECT_GT(fix->identity, 0.999);
    }
    TagSighting broken = tag_of(0, 4);
    broken.corners[2].pixel.x() = std::numeric_limits<double>::quiet_NaN();
    tracker.observe(from_seconds(4), "hall", broken);
    TagSighting three;
    tracker.observe(from_seconds(4), "hall", three);
    tracker.observe(from_seconds(4), "no such camera", tag_of(0, 4));
    EXPECT_EQ(tracker.counts().impossible, 3);
}

TEST(Tracker, GivesManyLookAlikesNumbersAndOneFalseSightingNone) {
    SiteRobot cart = robot_of("cart", Cylinder{0.5, 1.7});
    cart.many = true;
    Tracker tracker(site_of({cart}));
    for (int i = 0; i < 10; ++i) {
        std::vector<PoseObservation> frame = {place(0.03 * i, 0, 0.05), place(3, 0.03 * i, 0.05)};
        if (i == 4) frame.push_back(place(8, 8, 0.05));
        tracker.observe(from_seconds(0.1 * i), "hall", frame);
    }
    auto fixes = tracker.fixes(from_seconds(0.9));
    ASSERT_EQ(fixes.size(), 2U);
    std::sort(fixes.begin(), fixes.end(), [](const Fix& a, const Fix& b) { return a.robot < b.robot; });
    EXPECT_EQ(fixes[0].robot, "cart-1");
    EXPECT_EQ(fixes[1].robot, "cart-2");
}

TEST(Tracker, TellsTwoLookAlikesByTheirWheels) {
    Tracker tracker(site_of({robot_of("r1", Box{0.6, 0.4, 0.4}), robot_of("r2", Box{0.6, 0.4, 0.4})}));
    // r2 drives along y = 1, r1 along y = 4; the camera does not know which is which.
    for (int i = 0; i < 60; ++i) {
        const double t = 0.1 * i;
        tracker.observe({from_seconds(t), 0, {0.2 * t, 0, 0}});
        tracker.observe({from_seconds(t), 1, {0.5 * t, 0, 0}});
        const std::vector<PoseObservation> frame = {seen(1 + 0.5 * t, 1, 0, 0.01, 2, 0), seen(1 + 0.2 * t, 4, 0, 0.01, 2, 1)};
        tracker.observe(from_seconds(t), "hall", frame);
        if (i == 1) {
            for (const Fix& fix : tracker.fixes(from_seconds(t)))
                EXPECT_TRUE(fix.status == FixStatus::none || fix.identity < 0.9) << "nobody can know this yet";
        }
    }
    const auto fixes = tracker.fixes(from_seconds(5.9));
    ASSERT_EQ(fixes.size(), 2U);
    for (const Fix& fix : fixes) {
        EXPECT_NEAR(fix.pose.y, fix.robot == "r1" ? 4 : 1, 0.05);
        EXPECT_GT(fix.identity, 0.95);
    }
}

/// Five that look alike, all in view from the start: there are 120 ways to name them.
TEST(Tracker, TellsFiveLookAlikesByTheirWheels) {
    std::vector<SiteRobot> robots;
    for (const char* id : {"r1", "r2", "r3", "r4", "r5"}) robots.push_back(robot_of(id, Box{0.6, 0.4, 0.4}));
    Tracker tracker(site_of(robots));
    Random random(5);
    const std::array<double, 5> speed = {0.1, 0.35, 0.2, 0.45, 0};
    const std::array<int, 5> lane = {3, 1, 4, 0, 2};  // in which each drives: the camera lists them by their lanes
    for (int i = 0; i < 40; ++i) {
        const double t = 0.1 * i;
        std::vector<PoseObservation> frame(5);
        for (std::size_t r = 0; r < 5; ++r) {
            tracker.observe({from_seconds(t), static_cast<int>(r), {speed[r] * t, 0, 0}});
            frame[static_cast<std::size_t>(lane[r])] = seen(1 + speed[r] * t + random.normal(0.02), 1 + 1.5 * lane[r], 0, 0.02, 2, 0);
        }
        for (std::size_t place = 0; place < 5; ++place) frame[place].robot = static_cast<int>(place);
        tracker.observe(from_seconds(t), "hall", frame);
        for (const Fix& fix : tracker.fixes(from_seconds(t))) {
            if (fix.status == FixStatus::none || fix.identity < 0.95) continue;
            EXPECT_NEAR(fix.pose.y, 1 + 1.5 * lane[static_cast<std::size_t>(fix.robot[1] - '1')], 0.2) << fix.robot << " at " << t;
        }
    }
    const auto fixes = tracker.fixes(from_seconds(3.9));
    ASSERT_EQ(fixes.size(), 5U);
    for (const Fix& fix : fixes) {
        EXPECT_EQ(fix.status, FixStatus::ok) << fix.robot;
        EXPECT_NEAR(fix.pose.y, 1 + 1.5 * lane[static_cast<std::size_t>(fix.robot[1] - '1')], 0.1) << fix.robot;
        EXPECT_GT(fix.identity, 0.9) << fix.robot;
    }
}

/// Two robots of nearly one size drive different ways, and cameras name them the other way round most of the time: their wheels tell.
TEST(Tracker, TellsRobotsOfNearlyOneSizeByTheirWheelsWhereCamerasTakeOneForTheOther) {
    Tracker tracker(site_of({robot_of("mast", Box{0.58, 0.39, 1.05}), robot_of("cart", Box{0.57, 0.36, 0.9})}));
    Random random(3);
    for (int i = 0; i < 60; ++i) {
        const double t = 0.1 * i;
        const double x = 0.4 * t, y = 0.4 * t;
        tracker.observe({from_seconds(t), 0, {x, 0, 0}});
        tracker.observe({from_seconds(t), 1, {y * std::cos(0.3 * t), y * std::sin(0.3 * t), 0.6 * t}});
        const bool exchanged = i % 5 != 0;
        const std::vector<PoseObservation> seen = {place(1 + x + random.normal(0.02), 1, 0.02, exchanged ? 1 : 0),
                                                   place(6 + y * std::cos(0.3 * t), 3 + y * std::sin(0.3 * t) + random.normal(0.02), 0.02, exchanged ? 0 : 1)};
        tracker.observe(from_seconds(t), "hall", seen);
    }
    const auto mast = tracker.fix(0, from_seconds(5.9));
    const auto cart = tracker.fix(1, from_seconds(5.9));
    ASSERT_TRUE(mast && cart);
    EXPECT_NEAR(mast->pose.x, 1 + 0.4 * 5.9, 0.1);
    EXPECT_NEAR(mast->pose.y, 1, 0.1);
    EXPECT_GT(cart->pose.y, 2.5);
    EXPECT_GT(mast->identity, 0.97);
}

/// What a description leaves out is the same in the next frame: many frames of a robot that stands are hardly more exact than one.
TEST(Tracker, ManySightingsWithALastingErrorAreNotMuchMoreExactThanOne) {
    const auto sigma_after = [](const std::function<void(PoseObservation&, int)>& prepare) {
        Tracker tracker(box_site);
        for (int i = 0; i < 30; ++i) {
            PoseObservation o = seen(2, 2, 0, 0.04);
            prepare(o, i);
            tracker.observe({from_seconds(0.1 * i), 0, {0, 0, 0}});
            see(tracker, 0.1 * i, "left+right", o);
        }
        return std::sqrt(tracker.fix(0, from_seconds(2.9))->covariance(0, 0));
    };
    const auto last = [](PoseObservation& o, double sigma, int only_camera) {
        o.lasting.root = Eigen::Vector3d(sigma, sigma, 0).asDiagonal();
        o.lasting.only_camera = only_camera;
    };
    const double free = sigma_after([](PoseObservation&, int) {});
    const double lasting = sigma_after([&](PoseObservation& o, int) { last(o, 0.037, -1); });
    const double by_turns = sigma_after([&](PoseObservation& o, int i) { last(o, 0.037, i % 2); });
    EXPECT_LT(free, 0.01) << "frames that have nothing in common average out";
    EXPECT_GT(lasting, 0.02) << "in 3 s it has become another error once or twice";
    EXPECT_LT(lasting, 0.04);
    EXPECT_LT(by_turns, 0.8 * lasting) << "each of two cameras errs in its own way";
    EXPECT_GT(by_turns, 0.6 * lasting);
}

/// A cart that cameras take for the lower rover, as its load fills the rover's box better, and the other way round: each frame says by how much.
TEST(Tracker, WeighsByHowMuchASightingIsOfOneKindAndNotOfAnother) {
    const std::vector<SiteRobot> robots = {robot_of("rover", Box{0.65, 0.55, 0.5}), robot_of("cart", Box{0.64, 0.37, 0.85})};
    const auto as = [](PoseObservation o, double rover, double cart) {
        o.kinds.push_back(rover);
        o.kinds.push_back(cart);
        return o;
    };
    Tracker by_looks(site_of(robots)), by_wheels(site_of(robots));
    for (int i = 0; i < 40; ++i) {
        const double t = 0.1 * i;
        // By turns either is taken for the cart, but the one at y = 4 more plainly.
        const std::vector<PoseObservation> frame = {as(place(1 + 0.4 * t, 1, 0.02, i % 2), i % 2 == 0 ? 0 : -0.3, i % 2 == 0 ? -0.3 : 0),
                                                    as(place(6, 4, 0.02, 1 - i % 2), i % 2 == 0 ? -5 : 0, i % 2 == 0 ? 0 : 1)};
        by_looks.observe(from_seconds(t), "hall", frame);
        for (const int robot : {0, 1}) by_wheels.observe({from_seconds(t), robot, {robot == 1 ? 0.4 * t : 0, 0, 0}});
        by_wheels.observe(from_seconds(t), "hall", frame);
    }
    ASSERT_TRUE(by_looks.fix(1, from_seconds(3.9)) && by_wheels.fix(1, from_seconds(3.9)));
    EXPECT_NEAR(by_looks.fix(1, from_seconds(3.9))->pose.y, 4, 0.1);
    EXPECT_NEAR(by_wheels.fix(1, from_seconds(3.9))->pose.y, 1, 0.1) << "wheels tell more than looks";
}

/// Where nothing else tells, what cameras take them for decides.
TEST(Tracker, RobotsOfNearlyOneSizeHaveTheNamesThatCamerasGiveThem) {
    Tracker tracker(site_of({robot_of("mast", Box{0.58, 0.39, 1.05}), robot_of("cart", Box{0.57, 0.36, 0.9})}));
    for (int i = 0; i < 40; ++i) {
        const std::vector<PoseObservation> seen = {place(1, 1, 0.02, 1), place(6, 3, 0.02, 0)};
        tracker.observe(from_seconds(0.1 * i), "hall", seen);
    }
    ASSERT_TRUE(tracker.fix(0, from_seconds(3.9)) && tracker.fix(1, from_seconds(3.9)));
    EXPECT_NEAR(tracker.fix(0, from_seconds(3.9))->pose.x, 6, 0.1);
    EXPECT_NEAR(tracker.fix(1, from_seconds(3.9))->pose.x, 1, 0.1);
}

/// One vague sighting beside a robot starts a track without a name, which is nearer to what is seen from then on. But nothing shows both at once.
TEST(Tracker, AStrangerThatNoFrameShowsBesideARobotDoesNotTakeItsSightings) {
    Tracker tracker(site_of({robot_of("r1", Box{0.6, 0.4, 0.4}), robot_of("r2", Box{0.6, 0.4, 0.4})}));
    for (int i = 0; i < 70; ++i) {
        const double t = 0.1 * i;
        tracker.observe({from_seconds(t), 0, {0.2 * t, 0, 0}});
        tracker.observe({from_seconds(t), 1, {0.5 * t, 0, 0}});
        PoseObservation second = seen(1 + 0.5 * t, 1, 0, 0.01, 2, 1);
        if (i == 40) {
            second = place(1 + 0.5 * t, 1.3, 0.25, 1);
            second.covariance(1, 1) = 0.05 * 0.05;
        } else if (i > 40) {
            second = place(1 + 0.5 * t, 1.17, 0.06, 1);
        }
        tracker.observe(from_seconds(t), "hall", std::vector<PoseObservation>{seen(1 + 0.2 * t, 4, 0, 0.01, 2, 0), second});
        if (i < 45) continue;
        const auto fix = tracker.fix(1, from_seconds(t));
        ASSERT_TRUE(fix);
        EXPECT_EQ(fix->status, FixStatus::ok) << "at " << t;
        EXPECT_NEAR(fix->pose.y, 1.1, 0.12) << "at " << t;
    }
}

/// Two look-alikes drive and are seen for three seconds; from then on r2 is not, and cameras say that it is not where it should be.
class OneOfTwoIsMissing : public ::testing::Test {
protected:
    /// One picture, 0.1 s after the last one, of r1 and of `others`; where r2 should be nothing shows, by so many nats.
    void show(std::vector<PoseObservation> others, double nats) {
        const double t = now();
        tracker_.observe({from_seconds(t), 0, {0.3 * t, 0, 0}});
        tracker_.observe({from_seconds(t), 1, {0.5 * t, 0, 0}});
        others.push_back(seen(1 + 0.3 * t, 5, 0, 0.01, 2, 0));
        tracker_.observe(from_seconds(t), "hall", others);
        const auto fix = tracker_.fix(1, from_seconds(t));
        if (nats < 0 && fix && fix->status != FixStatus::none) tracker_.observe(from_seconds(t), "hall", AbsenceObservation{1, fix->pose, nats});
        ++frames_;
    }
    void drive_in_view() {
        while (frames_ < 30) show({seen(1 + 0.5 * now(), 1, 0, 0.01, 2, 1)}, 0);
        ASSERT_EQ(last_fix()->status, FixStatus::ok);
    }
    double now() const { return 0.1 * frames_; }
    std::optional<Fix> last_fix() const { return tracker_.fix(1, from_seconds(now() - 0.1)); }

    Tracker tracker_{site_of({robot_of("r1", Box{0.6, 0.4, 0.4}), robot_of("r2", Box{0.6, 0.4, 0.4})})};
    int frames_ = 0;
};

TEST_F(OneOfTwoIsMissing, WhatStandsElsewhereWhileItsWheelsTurnIsNotIt) {
    drive_in_view();
    while (frames_ < 65) {  // it drives behind something
        show({seen(2, 3, 0.4, 0.01, 2, 1)}, -3);
        const auto fix = last_fix();
        if (!fix || fix->status != FixStatus::ok) continue;
        EXPECT_NEAR(fix->pose.y, 1, 0.3) << now();
    }
    while (frames_ < 80) show({seen(2, 3, 0.4, 0.01, 2, 1), seen(1 + 0.5 * now(), 1, 0, 0.01, 2, 1)}, 0);
    ASSERT_TRUE(last_fix());
    EXPECT_EQ(last_fix()->status, FixStatus::ok);
    EXPECT_NEAR(last_fix()->pose.y, 1, 0.1);
}

TEST_F(OneOfTwoIsMissing, WhatMovesElsewhereAsItsWheelsSayIsItThoughItMayJustBeHidden) {
    drive_in_view();
    const double begin = now();
    while (frames_ < 60) {  // it was set down elsewhere, and drives on there
        const double way = 0.5 * (now() - begin);
        show({seen(6 + 0.6 * way, 3 + 0.8 * way, std::atan2(0.8, 0.6), 0.01, 2, 1)}, 0);  // nobody sees the place where it should be
    }
    const auto fix = last_fix();
    ASSERT_TRUE(fix);
    EXPECT_EQ(fix->status, FixStatus::ok);
    EXPECT_GT(fix->pose.y, 3);
}

TEST(Tracker, NamesWhereSomethingLikeARobotIsSeenWhileAllAreFollowedElsewhere) {
    Tracker tracker(site_of({robot_of("r1", Box{0.5, 0.4, 0.4}), robot_of("r2", Box{0.5, 0.4, 0.4})}));
    const auto show = [&](double t, std::vector<PoseObservation> robots) { tracker.observe(from_seconds(t), "hall", robots); };
    for (int i = 0; i < 30; ++i) show(0.1 * i, {place(1, 2), place(4, 2, 0.01, 1)});
    EXPECT_TRUE(tracker.nameless(from_seconds(2.9)).empty());
    for (int i = 30; i < 33; ++i) show(0.1 * i, {place(1, 2), place(4, 2, 0.01, 1), place(6, 5)});
    const auto nameless = tracker.nameless(from_seconds(3.2));
    ASSERT_EQ(nameless.size(), 1U);
    EXPECT_NEAR(nameless[0].pose.x, 6, 0.1);
    EXPECT_NEAR(nameless[0].pose.y, 5, 0.1);
    EXPECT_EQ(tracker.expected(from_seconds(3.2)).size(), 2U) << "each robot is expected at one place";
}

TEST(Tracker, KeepsTheNamesOfLookAlikesThatNothingTellsApartAndSaysThatTheyAreChance) {
    Tracker tracker(site_of({robot_of("r1", Box{0.6, 0.4, 0.4}), robot_of("r2", Box{0.6, 0.4, 0.4})}));
    double y_of_r1 = -1;
    for (int i = 0; i < 60; ++i) {
        const double t = 0.1 * i;
        std::vector<PoseObservation> frame = {seen(1 + 0.2 * t, 1, 0, 0.01, 2, 0), seen(1 + 0.2 * t, 4, 0, 0.01, 2, 1)};
        if (i % 2 == 1) std::swap(frame[0], frame[1]);
        tracker.observe(from_seconds(t), "hall", frame);
        if (i < 3) continue;
        const auto fixes = tracker.fixes(from_seconds(t));
        ASSERT_EQ(fixes.size(), 2U);
        for (const Fix& fix : fixes) {
            EXPECT_EQ(fix.status, FixStatus::ok);
            if (fix.robot != "r1") continue;
            if (y_of_r1 < 0) y_of_r1 = fix.pose.y;
            EXPECT_NEAR(fix.pose.y, y_of_r1, 0.1) << "at " << t;
        }
        EXPECT_LT(std::min(fixes[0].identity, fixes[1].identity), 0.6) << "which of them the first one is, nobody knows";
    }
}

TEST(Tracker, HoldsNamesBackThatWheelsWillTellAndExpectsTheRobotsAllTheSame) {
    Tracker tracker(site_of({robot_of("r1", Box{0.6, 0.4, 0.4}), robot_of("r2", Box{0.6, 0.4, 0.4})}));
    for (int i = 0; i < 30; ++i) {
        const double t = 0.1 * i;
        for (const int robot : {0, 1}) tracker.observe({from_seconds(t), robot, {0, 0, 0}});  // both stand still: nothing tells them apart
        tracker.observe(from_seconds(t), "hall", std::vector<PoseObservation>{seen(1, 1, 0, 0.01, 2, 0), seen(1, 4, 0, 0.01, 2, 1)});
        if (i == 10) {
            for (const Fix& fix : tracker.fixes(from_seconds(t))) {
                EXPECT_EQ(fix.status, FixStatus::none);
                EXPECT_NE(fix.reason.find("look the same"), std::string::npos) << fix.reason;
            }
            EXPECT_EQ(tracker.expected(from_seconds(t)).size(), 2U) << "cameras look for them where they are";
        }
    }
    for (const Fix& fix : tracker.fixes(from_seconds(2.9))) {
        EXPECT_EQ(fix.status, FixStatus::ok) << "after so long they are given with their doubt";
        EXPECT_LT(fix.identity, 0.95);
    }
}

TEST(Belief, StaysPositiveDefiniteInTenMillionUpdates) {
    Random random(7);
    Belief belief = belief_at({4, 3, 0}, Eigen::Vector3d(1e4, 1e4, 3).asDiagonal(), 1, 1, {});
    MotionModel motion;
    motion.drive = Drive::differential;
    RangeSource source{{0.1, 0, 0.3}, {}, 0.1, 0.01, 600};
    source.own_sigma = own_part * source.bias_sigma;
    PoseObservation pose = seen(4, 3, 0, 1e-5);
    pose.covariance(2, 2) = 1e-12;
    int checked = 0;
    for (int i = 0; i < 10'000'000; ++i) {
        if (i % 4 == 0) predict(belief, 0.01, motion);
        const int b = i % 4;
        const double range = (Eigen::Vector3d(4, 3, 0) - box_site.beacons[static_cast<std::size_t>(b)].position).norm() + random.normal(0.02);
        update_range(belief, {0, 0, b, range, 0.02}, box_site.beacons[static_cast<std::size_t>(b)].position, source);
        if (i % 1000 == 0) update(belief, linearise_pose(belief, pose, {}), {0.01, std::numeric_limits<double>::infinity(), -10});
        if (i % 9973 != 0) continue;
        const Eigen::MatrixXd p = belief.covariance.topLeftCorner(belief.size, belief.size);
        ASSERT_EQ((p - p.transpose()).cwiseAbs().maxCoeff(), 0) << i;
        ASSERT_EQ(Eigen::LLT<Eigen::MatrixXd>(p).info(), Eigen::Success) << i;
        ++checked;
    }
    EXPECT_GT(checked, 1000);
}

}  // namespace
}  // namespace roomfix
