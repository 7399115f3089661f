#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "overhead/evidence_of.hpp"
#include "roomfix/base/decompositions.hpp"
#include "roomfix/overhead/body_observer.hpp"
#include "standing_camera.hpp"

namespace roomfix {
namespace {

const SiteRobot can{"can", Cylinder{0.45, 1.2}};
const SiteRobot cart{"cart", Box{0.8, 0.5, 0.4}};

TEST(BodySearch, TwoCamerasTogetherFindABodyWithAnHonestCovariance) {
    const View left = standing_camera({-2, 0, 2.2}, {2, 1, 0});
    const View right = standing_camera({2, -3, 2.4}, {2, 1, 0});
    const Pose2 truth{2.1, 0.8, 0};
    const Body body = body_of(can);
    const Evidence a = evidence_of(left, {{body, truth}});
    const Evidence b = evidence_of(right, {{body, truth}});
    const std::vector<SeenBy> seen = {{&left, &a}, {&right, &b}};
    BodyObserver observer({can});
    const auto& found = observer.find(seen, {1});
    ASSERT_EQ(found.size(), 1U);
    const Eigen::Vector2d off(found[0].place.pose.x - truth.x, found[0].place.pose.y - truth.y);
    EXPECT_LT(off.norm(), 0.04);
    const Eigen::Matrix2d covariance = found[0].place.covariance.topLeftCorner<2, 2>();
    EXPECT_LT(off.dot(covariance.inverse() * off), 9);
    EXPECT_GT(found[0].place.covariance(0, 0), 1e-6);
    const Eigen::Matrix3d lasting = found[0].place.lasting.root * found[0].place.lasting.root.transpose();
    EXPECT_GT(lasting(0, 0), 0.5 * found[0].place.covariance(0, 0)) << "the next frame errs in the same way";
    EXPECT_GT((covariance - lasting.topLeftCorner<2, 2>()).determinant(), 0);
    EXPECT_EQ(found[0].place.lasting.only_camera, -1);
    EXPECT_EQ(std::count(found[0].place.seen.begin(), found[0].place.seen.end(), 1), 2);
}

TEST(BodySearch, ABoxIsFoundWithItsHeading) {
    const View left = standing_camera({-1, -1, 3}, {2, 1, 0});
    const Pose2 truth{2.0, 1.1, 0.6};
    const Body body = body_of(cart);
    const Evidence a = evidence_of(left, {{body, truth}});
    const std::vector<SeenBy> seen = {{&left, &a}};
    BodyObserver observer({cart});
    const auto& found = observer.find(seen, {1});
    ASSERT_EQ(found.size(), 1U);
    EXPECT_LT(std::hypot(found[0].place.pose.x - truth.x, found[0].place.pose.y - truth.y), 0.08);
    EXPECT_LT(std::abs(std::remainder(found[0].place.pose.yaw - truth.yaw, body.symmetry)), 0.15);
    EXPECT_GT(found[0].place.lasting.root.norm(), 0) << "one camera alone errs as long as several";
    EXPECT_EQ(found[0].place.lasting.only_camera, 0);
}

TEST(BodySearch, ASightingSaysHowMuchLessRobotsOfOtherKindsExplainIt) {
    const View left = standing_camera({-1, -1, 3}, {2, 1, 0});
    const View right = standing_camera({4, -2, 2.6}, {2, 1, 0});
    const SiteRobot tall{"tall", Box{0.75, 0.45, 0.8}};
    const Pose2 truth{2.0, 1.1, 0.6};
    const Evidence a = evidence_of(left, {{body_of(tall), truth}});
    const Evidence b = evidence_of(right, {{body_of(tall), truth}});
    const std::vector<SeenBy> seen = {{&left, &a}, {&right, &b}};
    BodyObserver observer({can, cart, tall});
    const auto& found = observer.find(seen, {1, 1, 1});
    ASSERT_EQ(found.size(), 1U);
    EXPECT_EQ(found[0].robot, 2);
    ASSERT_EQ(found[0].kinds.size(), 3U);
    EXPECT_LT(found[0].kinds[0], -3);
    EXPECT_LT(found[0].kinds[1], -3);
    EXPECT_EQ(found[0].kinds[2], 0);
}

/// A low, wide robot with a thin mast: it covers little of the box around it.
SiteRobot rover() {
    SiteRobot robot{"rover", Box{}};
    const auto add = [&](double length, double width, double low, double high) {
        ConvexPart part;
        for (int i = 0; i < 8; ++i) part.points.emplace_back(i & 1 ? length / 2 : -length / 2, i & 2 ? width / 2 : -width / 2, i & 4 ? high : low);
        robot.parts.push_back(part);
    };
    add(0.7, 0.4, 0.1, 0.25);
    add(0.04, 0.04, 0.25, 0.8);
    return robot;
}

/// The evidence of a rover that hardly differs from the floor but for its lowest rows.
Evidence evidence_of_pale(const View& view, const Body& body, const Pose2& pose) {
    Evidence evidence = evidence_of(view, {{body, pose}});
    BodyMask mask;
    cover(view, body.parts, pose, 640, 480, 1, 1, mask);
    for (int y = 0; y < mask.bottom - (mask.bottom - mask.top) / 9; ++y) {
        for (int x = 0; x < 640; ++x) evidence.pixels[static_cast<std::size_t>(y * 640 + x)] = {0, Evidence::certain};
    }
    evidence.sum_up();
    return evidence;
}

TEST(BodySearch, ARobotThatCoversLittleOfItsBoxIsFound) {
    const View view = standing_camera({-2, -1, 2.4}, {2, 1, 0});
    const Pose2 truth{2.0, 1.1, 0.6};
    const SiteRobot robot = rover();
    EXPECT_LT(body_of(robot).share_of_box, 0.2);
    const Evidence evidence = evidence_of(view, {{body_of(robot), truth}});
    const std::vector<SeenBy> seen = {{&view, &evidence}};
    BodyObserver observer({robot});
    const auto& found = observer.find(seen, {1}, {}, {}, [](const BodySighting&) { return 0.0; });
    ASSERT_EQ(found.size(), 1U);
    EXPECT_LT(std::hypot(found[0].place.pose.x - truth.x, found[0].place.pose.y - truth.y), 0.1);
}

TEST(BodySearch, EdgesShowARobotThatHardlyDiffersFromTheFloor) {
    const View view = standing_camera({-2, -1, 2.4}, {2, 1, 0});
    const Pose2 truth{3.4, 1.1, 0.6};
    const SiteRobot robot = rover();
    const Evidence evidence = evidence_of_pale(view, body_of(robot), truth);
    const std::vector<SeenBy> seen = {{&view, &evidence}};
    EXPECT_TRUE(BodyObserver({robot}).find(seen, {1}).empty()) << "by its area it is none";
    BodyObserverSettings settings;
    settings.search.score.floor_coloured = 0.1;
    BodyObserver observer({robot}, settings);
    const auto near_truth = [&](const BodySighting& s) { return std::hypot(s.place.pose.x - truth.x, s.place.pose.y - truth.y) < 0.5; };
    int asked = 0;
    const auto& found = observer.find(seen, {1}, {}, {}, [&](const BodySighting& s) {
        ++asked;
        return near_truth(s) ? 15.0 : -5.0;
    });
    EXPECT_GT(asked, 0);
    ASSERT_EQ(found.size(), 1U);
    EXPECT_TRUE(near_truth(found[0]));
    EXPECT_TRUE(observer.find(seen, {1}, {}, {}, [](const BodySighting&) { return -5.0; }).empty()) << "nor where its edges are not";
}

/// A grey robot on a grey floor: most of it may as well be a shadow, which says nothing.
TEST(BodySearch, OfARobotThatMightBeAShadowLittleIsEnoughWhereEdgesTellTheRest) {
    const View view = standing_camera({-2, -1, 2.4}, {2, 1, 0});
    const Pose2 truth{2.0, 1.1, 0.6};
    SiteRobot torso{"torso", Box{}};
    for (const auto& [width, low, high] : {std::array{0.5, 0.0, 0.2}, std::array{0.3, 0.2, 0.9}}) {
        ConvexPart part;
        for (int i = 0; i < 8; ++i) part.points.emplace_back(i & 1 ? width / 2 : -width / 2, i & 2 ? width / 2 : -width / 2, i & 4 ? high : low);
        torso.parts.push_back(part);
    }
    Evidence evidence = evidence_of(view, {{body_of(torso), truth}});
    int differs = 0, all = 0;
    for (Evidence::Pixel& pixel : evidence.pixels) {
        if (pixel.other == 0) continue;
        ++all;
        if (all % 29 == 0) {
            ++differs;
        } else {
            pixel = {0, 0};
        }
    }
    evidence.sum_up();
    ASSERT_GT(differs, 100);
    const std::vector<SeenBy> seen = {{&view, &evidence}};
    BodyObserverSettings settings;
    settings.search.least_other = 0.2;  // of other bodies more must differ
    BodyObserver observer({torso}, settings);
    const auto near_truth = [&](const BodySighting& s) { return std::hypot(s.place.pose.x - truth.x, s.place.pose.y - truth.y) < 0.3; };
    const auto& found = observer.find(seen, {1}, {}, {}, [&](const BodySighting& s) { return near_truth(s) ? 15.0 : -5.0; });
    ASSERT_EQ(found.size(), 1U);
    EXPECT_TRUE(near_truth(found[0]));
    settings.search.more_than_by_chance = 1e9;  // and of this one, too
    EXPECT_TRUE(BodyObserver({torso}, settings).find(seen, {1}, {}, {}, [](const BodySighting&) { return 15.0; }).empty());
}

TEST(BodySearch, WhatHasOtherEdgesIsNoRobotUnlessItIsExpectedThere) {
    const View view = standing_camera({-2, -1, 2.4}, {2, 1, 0});
    const Pose2 truth{2.0, 1.1, 0.6};
    const SiteRobot robot = rover();
    const Evidence evidence = evidence_of(view, {{body_of(robot), truth}});
    const std::vector<SeenBy> seen = {{&view, &evidence}};
    BodyObserver observer({robot});
    int asked = 0;
    const EdgeJudge other = [&](const BodySighting&) {
        ++asked;
        return -8.0;
    };
    EXPECT_TRUE(observer.find(seen, {1}, {}, {}, other).empty());
    EXPECT_LE(asked, BodyObserverSettings().most_strange + 1) << "only so many places are asked about in one frame";
    Expectation expected;
    PoseObservation there;
    there.pose = truth;
    there.covariance = Eigen::Vector3d(1e-4, 1e-4, 1e-2).asDiagonal();
    expected.robots = {there};
    EXPECT_EQ(observer.find(seen, {1}, {}, expected, other).size(), 1U) << "where it was a moment ago it is likelier than another thing";
}

/// The head and shoulders of a person with trousers like the floor might be a low robot that stands far behind.
TEST(BodySearch, WhatAPersonShowsAboveTheWaistIsNoRobotFarBehind) {
    const View view = standing_camera({-2, -1, 2.4}, {2, 1, 0});
    const SiteRobot robot{"low", Box{0.6, 0.5, 0.5}};
    const Pose2 truth{1.4, 0.6, 0};
    Evidence evidence = evidence_of(view, {{body_of({"person", Cylinder{0.5, 1.7}}), truth}});
    BodyMask legs;
    cover(view, body_of({"legs", Cylinder{0.6, 0.9}}).parts, truth, 640, 480, 1, 1, legs);
    for (const Span& span : legs.spans) {
        for (int x = span.begin; x < span.end; ++x) {
            if ((x + span.y) % 4) evidence.pixels[static_cast<std::size_t>(span.y * 640 + x)] = {0, Evidence::certain};
        }
    }
    evidence.sum_up();
    const std::vector<SeenBy> seen = {{&view, &evidence}};
    const auto candidates = BodySearch().candidates(seen, body_of(robot));
    ASSERT_FALSE(candidates.empty());
    EXPECT_GT(candidates[0].score, 100);  // by what differs it were one
    EXPECT_TRUE(BodyObserver({robot}).find(seen, {1}).empty());
    BodyObserverSettings settings;
    settings.same_pixels = 2;  // nobody asks
    settings.search.score.goes_on = settings.search.score.something_beside;
    EXPECT_FALSE(BodyObserver({robot}, settings).find(seen, {1}).empty());
}

/// A box that is larger than the robot is refused where it explains most, and then also where the robot would stand before or behind it.
TEST(BodySearch, WhatIsNoRobotAtItsLikeliestPlaceIsNoneAlongTheRayEither) {
    const View view = standing_camera({-2, -1, 2.4}, {2, 1, 0});
    for (const double yaw : {0.3, 1.2}) {
        const Evidence evidence = evidence_of(view, {{body_of({"larger", Box{0.9, 0.9, 0.5}}), {0.9, 0.5, yaw}}});
        const std::vector<SeenBy> seen = {{&view, &evidence}};
        EXPECT_TRUE(BodyObserver({cart}).find(seen, {1}).empty()) << yaw;
        BodyObserverSettings settings;
        settings.same_pixels = 2;  // no place is along another one's ray
        EXPECT_FALSE(BodyObserver({cart}, settings).find(seen, {1}).empty()) << yaw;
    }
}

TEST(BodySearch, WhatGoesOnBeyondTheOutlineHasNotTheBodysShape) {
    const View view = standing_camera({-2, -1, 2.4}, {2, 1, 0});
    const Pose2 truth{1.8, 0.9, 0.4};
    const Body body = body_of(cart);
    PlaceMemory memory;
    const auto shape_in = [&](const std::vector<std::pair<Body, Pose2>>& bodies) {
        const Evidence evidence = evidence_of(view, bodies);
        return score_shape({&view, &evidence}, body, truth, {}, memory);
    };
    EXPECT_GT(shape_in({{body, truth}}), 3);
    const Body larger = body_of({"larger", Box{2, 1.6, 1}});
    EXPECT_LT(shape_in({{larger, truth}}), -5);
    // To one side something may stand.
    const double beside = shape_in({{body, truth}, {body, {1.95, 0.5, 0.4}}});
    EXPECT_GT(beside, 0);
    EXPECT_LT(beside, shape_in({{body, truth}}));
    const View elsewhere = standing_camera({-2, -1, 2.4}, {-4, -2, 0});
    const Evidence nothing = evidence_of(elsewhere, {});
    EXPECT_EQ(score_shape({&elsewhere, &nothing}, body, truth, {}, memory), 0);
}

/// A robot is followed; a person stands between it and the camera, so that its pixels and the person's are next to each other.
TEST(BodySearch, AKnownThingIsNotTakenForTheRobotThatItHides) {
    const View view = standing_camera({-2, -1, 2.6}, {2, 1, 0});
    const SiteRobot low{"low", Box{0.4, 0.3, 0.25}};
    const Body person = body_of({"person", Cylinder{0.5, 1.7}});
    const auto largest_error = [&](bool known) {
        double largest = 0;
        for (const double aside : {0.15, 0.20, 0.25, 0.30}) {
            const Pose2 stands{0.4, 0.7 - aside, 0}, truth{2.0, 0.95, 0.3};
            const Evidence evidence = evidence_of(view, {{person, stands}, {body_of(low), truth}});
            const std::vector<SeenBy> seen = {{&view, &evidence}};
            Expectation expected;
            expected.search = false;
            const Eigen::Matrix3d spread = Eigen::Vector3d(0.1 * 0.1, 0.1 * 0.1, 0.1).asDiagonal();
            expected.robots = {{0, {truth.x - 0.1, truth.y + 0.1, truth.yaw}, true, spread}};
            if (known) expected.things = {{-1, stands, false, Eigen::Vector3d(0.04, 0.04, 1).asDiagonal()}};
            BodyObserver observer({low});
            const auto& found = observer.find(seen, {1}, {}, expected);
            largest = std::max(largest, found.empty() ? 1 : std::hypot(found[0].place.pose.x - truth.x, found[0].place.pose.y - truth.y));
        }
        return largest;
    };
    EXPECT_GT(largest_error(false), 0.1);
    EXPECT_LT(largest_error(true), 0.02);
}

/// What nobody expects is found in every search, whether it is looked for before the robots or in what they leave; and so is a robot that is followed where
/// something else stands, within a few searches.
TEST(BodySearch, WhatNobodyExpectsIsFoundInEverySearch) {
    const View left = standing_camera({-1, -1, 3}, {2, 1, 0});
    const View right = standing_camera({4, -2, 2.6}, {2, 1, 0});
    const Body person = body_of({"person", Cylinder{0.5, 1.7}});
    const Pose2 truth{2.0, 1.0, 0.4}, stands{1.2, 2.0, 0};
    const Evidence a = evidence_of(left, {{person, stands}, {body_of(cart), truth}});
    const Evidence b = evidence_of(right, {{person, stands}, {body_of(cart), truth}});
    const std::vector<SeenBy> seen = {{&left, &a}, {&right, &b}};
    const Eigen::Matrix3d spread = Eigen::Vector3d(0.05 * 0.05, 0.05 * 0.05, 0.1).asDiagonal();
    const BodyObserverSettings settings;
    const auto error_of = [&](const std::vector<BodySighting>& found) {
        return found.size() == 1 ? std::hypot(found[0].place.pose.x - truth.x, found[0].place.pose.y - truth.y) : 1;
    };
    {
        BodyObserver observer({cart});
        Expectation expected;
        expected.robots = {{0, truth, true, spread}};
        for (int search = 0; search < 2 * settings.searches_apart; ++search) {
            EXPECT_LT(error_of(observer.find(seen, {1}, {}, expected)), 0.05) << search;
            ASSERT_EQ(observer.things().size(), 1U) << search;
            EXPECT_LT(std::hypot(observer.things()[0].pose.x - stands.x, observer.things()[0].pose.y - stands.y), 0.1) << search;
        }
    }
    BodyObserver observer({cart});
    Expectation mistaken;
    mistaken.robots = {{0, stands, true, spread}};
    bool right_once = false;
    for (int search = 0; search < settings.searches_apart; ++search) right_once |= error_of(observer.find(seen, {1}, {}, mistaken)) < 0.05;
    EXPECT_TRUE(right_once);
}

/// What was seen before and taken for a thing may have been the robot that is still missing.
TEST(BodySearch, ARobotThatIsMissingMayBeWhatSeemedToBeAThing) {
    const View left = standing_camera({-1, -1, 3}, {2, 1, 0});
    const View right = standing_camera({4, -2, 2.6}, {2, 1, 0});
    const SiteRobot bin{"bin", Cylinder{0.58, 0.95}};  // as large as a chair
    const Pose2 truth{2.0, 1.1, 0.6};
    const Evidence a = evidence_of(left, {{body_of(bin), truth}});
    const Evidence b = evidence_of(right, {{body_of(bin), truth}});
    const std::vector<SeenBy> seen = {{&left, &a}, {&right, &b}};
    Expectation expected;
    expected.things = {{-1, {truth.x + 0.05, truth.y, 0}, false, Eigen::Vector3d(0.003, 0.003, 1).asDiagonal()}};
    BodyObserver observer({bin});
    const auto& found = observer.find(seen, {1}, {}, expected);
    ASSERT_EQ(found.size(), 1U);
    EXPECT_NEAR(found[0].place.pose.x, truth.x, 0.05);
    EXPECT_TRUE(observer.things().empty());
}

/// A small robot explains all of three places where robots stand, one of them its own: nobody takes that one for a thing because the robot may stand at
/// another one.
TEST(BodySearch, ASmallRobotHasAPlaceOfItsOwnBesideLargerOnes) {
    const View left = standing_camera({-2, -1, 3}, {2, 1, 0});
    const View right = standing_camera({6, -1, 2.8}, {2, 1, 0});
    const SiteRobot large{"large", Box{0.6, 0.42, 0.53}}, alike{"alike", Box{0.6, 0.42, 0.53}}, small{"small", Box{0.5, 0.3, 0.55}};
    const Body half_empty = body_of({"half-empty", Box{0.55, 0.34, 0.5}});
    const std::vector<Pose2> truth = {{0.6, 1.8, 0.4}, {3.4, 1.6, 2.0}, {2.0, 0.6, 1.1}};
    const std::vector<std::pair<Body, Pose2>> shown = {{half_empty, truth[0]}, {half_empty, truth[1]}, {body_of(small), truth[2]}};
    const Evidence a = evidence_of(left, shown);
    const Evidence b = evidence_of(right, shown);
    const std::vector<SeenBy> seen = {{&left, &a}, {&right, &b}};
    BodyObserver observer({large, alike, small});
    const auto& found = observer.find(seen, {1, 1, 1});
    ASSERT_EQ(found.size(), 3U);
    EXPECT_TRUE(observer.things().empty());
    for (const BodySighting& sighting : found) {
        if (sighting.robot == 2) EXPECT_LT(std::hypot(sighting.place.pose.x - truth[2].x, sighting.place.pose.y - truth[2].y), 0.1);
    }
}

TEST(BodySearch, AnEmptyFloorHasNoBody) {
    const View left = standing_camera({-1, -1, 3}, {2, 1, 0});
    const Evidence a = evidence_of(left, {});
    const std::vector<SeenBy> seen = {{&left, &a}};
    BodyObserver observer({can, cart});
    EXPECT_TRUE(observer.find(seen, {1, 1}).empty());
}

/// A cart is expected on bare floor, or behind a robot that hides most of it.
TEST(BodySearch, WhatIsMostlyHiddenIsNotCalledAbsent) {
    const View view = standing_camera({-1, 1, 1.2}, {2, 1, 0.3});
    const SiteRobot screen{"screen", Box{0.2, 0.9, 0.8}};
    const Pose2 in_front{1.6, 1, 0};
    const Evidence evidence = evidence_of(view, {{body_of(screen), in_front}});
    const std::vector<SeenBy> seen = {{&view, &evidence}};
    const std::vector<KnownRobot> known = {{1, in_front}};
    const auto absent = [&](const Pose2& place) {
        Expectation expected;
        expected.search = false;
        expected.robots = {{0, place, true, 1e-4 * Eigen::Matrix3d::Identity()}};
        BodyObserver observer({cart, screen});
        EXPECT_TRUE(observer.find(seen, {1, 0}, known, expected).empty());
        return observer.absent();
    };
    EXPECT_TRUE(absent({2.4, 1.52, 0}).empty()) << "most of it is hidden: perhaps all of it is";
    const auto bare = absent({2.4, 2.2, 0});
    ASSERT_EQ(bare.size(), 1U);
    EXPECT_EQ(bare[0].robot, 0);
    EXPECT_LT(bare[0].nats, -1.5);
}

TEST(BodySearch, WhatAKnownRobotExplainsIsNotFoundAgain) {
    const View left = standing_camera({-1, -1, 3}, {2, 1, 0});
    const Pose2 truth{2.0, 1.1, 0.6};
    const Evidence a = evidence_of(left, {{body_of(cart), truth}});
    const std::vector<SeenBy> seen = {{&left, &a}};
    BodyObserver observer({can, cart});
    const std::vector<KnownRobot> known = {{1, truth}};
    EXPECT_TRUE(observer.find(seen, {1, 0}, known).empty());
}

TEST(BodySearch, AnOutlineOfWhatAnotherRobotExplainsDoesNotHold) {
    const View left = standing_camera({-1, -1, 3}, {2, 1, 0});
    const Pose2 truth{2.0, 1.1, 0.6};
    const Evidence a = evidence_of(left, {{body_of(cart), truth}});
    const std::vector<SeenBy> seen = {{&left, &a}};
    BodyObserver observer({can, cart});
    const KnownRobot right{1, truth, false, 30};
    const KnownRobot inside{0, {2.05, 1.15, 0}, false, -5};
    const KnownRobot on_bare_floor{0, {1.0, 2.2, 0}, false, -5};
    const std::vector<KnownRobot> known = {inside, right, on_bare_floor};
    EXPECT_TRUE(observer.find(seen, {1, 1}, known).empty());
    EXPECT_TRUE(observer.holds(right));
    EXPECT_FALSE(observer.holds(inside)) << "two robots do not stand in each other";
    EXPECT_FALSE(observer.holds(on_bare_floor));
}

TEST(BodySearch, NothingIsFoundBehindAWall) {
    const View left = standing_camera({-1, -1, 3}, {2, 1, 0});
    const Pose2 truth{2.0, 1.1, 0.6};
    const Evidence a = evidence_of(left, {{body_of(cart), truth}});
    const std::vector<Polyline> across = {{{1, -3}, {1, 5}}};
    const std::vector<Polyline> behind_camera = {{{-1.05, -3}, {-1.05, 5}}, {{-1, -1.05}, {5, -1.05}}};
    BodyObserver observer({cart});
    const std::vector<SeenBy> hidden = {{&left, &a, &across}};
    for (const BodySighting& found : observer.find(hidden, {1})) EXPECT_LT(found.place.pose.x, 1.0);
    const std::vector<SeenBy> open = {{&left, &a, &behind_camera}};
    EXPECT_EQ(observer.find(open, {1}).size(), 1U);
}

TEST(BodySearch, TwoThatLookAlikeAreRivals) {
    const View left = standing_camera({-1, -1, 3}, {2, 2, 0});
    const Body body = body_of(can);
    const Evidence a = evidence_of(left, {{body, {2.2, 1.0, 0}}, {body, {1.0, 2.2, 0}}});
    const std::vector<SeenBy> seen = {{&left, &a}};
    BodyObserver observer({can});
    const auto& found = observer.find(seen, {1});
    ASSERT_EQ(found.size(), 1U);
    EXPECT_LT(found[0].place.weight, 0.99);
    ASSERT_FALSE(found[0].others.empty()) << "one of two things that look the same: nobody can know which";
    EXPECT_GT(found[0].place.covariance(0, 0) + found[0].place.covariance(1, 1), 0.05);
}

}  // namespace
}  // namespace roomfix
