#include "roomfix/overhead/place_score.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "overhead/evidence_of.hpp"
#include "roomfix/base/random.hpp"
#include "standing_camera.hpp"

namespace roomfix {
namespace {

/// One camera in a corner of the floor, and a cart that it may show.
class PlaceScoreOfACart : public ::testing::Test {
protected:
    PlaceScore score(const Evidence& evidence, const Pose2& pose, const std::vector<Polyline>* walls = nullptr) {
        return score_place({&view_, &evidence, walls}, body_, pose, {}, memory_);
    }
    double shape(const Evidence& evidence, const Pose2& pose) { return score_shape({&view_, &evidence, nullptr}, body_, pose, {}, memory_); }

    const View view_ = standing_camera({-1, -1, 3}, {2, 1, 0});
    const Body body_ = body_of({"cart", Box{0.8, 0.5, 0.4}});
    const Pose2 truth_{2, 1.1, 0.6};
    const Evidence empty_ = evidence_of(view_, {});
    const Evidence with_cart_ = evidence_of(view_, {{body_, truth_}});
    PlaceMemory memory_;
};

TEST_F(PlaceScoreOfACart, IsHighestWhereItStands) {
    const PlaceScore right = score(with_cart_, truth_);
    ASSERT_TRUE(right.in_picture);
    EXPECT_GT(right.log_ratio, 10);
    EXPECT_GT(right.filled, 0.8);
    EXPECT_LT(right.around, 0.2);
    for (int i = 0; i < 12; ++i) {
        const double direction = i * std::numbers::pi / 6;
        const auto beside = [&](double off) {
            return score(with_cart_, {truth_.x + off * std::cos(direction), truth_.y + off * std::sin(direction), truth_.yaw});
        };
        EXPECT_LT(beside(0.3).log_ratio, right.log_ratio) << direction;
        EXPECT_LT(beside(0.6).log_ratio, beside(0.2).log_ratio) << direction;
    }
    EXPECT_LT(score(with_cart_, {truth_.x, truth_.y, truth_.yaw + std::numbers::pi / 2}).log_ratio, right.log_ratio);
}

TEST_F(PlaceScoreOfACart, WhereNothingIsItIsHiddenOrNotThere) {
    const PlaceScore nothing = score(empty_, truth_);
    EXPECT_TRUE(nothing.in_picture);
    EXPECT_NEAR(nothing.log_ratio, std::log(PlaceScoreSettings().hidden), 0.01) << "one camera may have something before it";
}

TEST_F(PlaceScoreOfACart, OutsideThePictureTheCameraSaysNothing) {
    EXPECT_FALSE(score(empty_, {-4, -4, 0}).in_picture);
    EXPECT_EQ(score(empty_, {-4, -4, 0}).log_ratio, 0);
    EXPECT_EQ(shape(empty_, {-4, -4, 0}), 0);
}

TEST_F(PlaceScoreOfACart, BehindAWallTheCameraSaysNothing) {
    const std::vector<Polyline> walls = {{{0, 2}, {2, -1}}};
    EXPECT_FALSE(score(empty_, truth_, &walls).in_picture);
    EXPECT_EQ(score(empty_, truth_, &walls).log_ratio, 0);
}

TEST_F(PlaceScoreOfACart, WhatLooksTheSameEverywhereIsNoCart) {
    Evidence noise = empty_;
    Random random(32);
    for (Evidence::Pixel& pixel : noise.pixels) pixel = random.uniform() < 0.5 ? Evidence::Pixel{Evidence::certain, 0} : Evidence::Pixel{0, Evidence::certain};
    noise.sum_up();
    EXPECT_LT(score(noise, truth_).log_ratio, 0);
    EXPECT_NEAR(score(noise, truth_).filled, score(noise, truth_).around, 0.1);
}

TEST_F(PlaceScoreOfACart, WhatSaysNothingCountsForNothing) {
    Evidence silent = empty_;
    for (Evidence::Pixel& pixel : silent.pixels) pixel = {0, 0};
    silent.sum_up();
    EXPECT_NEAR(score(silent, truth_).log_ratio, 0, 1e-9);
}

TEST_F(PlaceScoreOfACart, OnlyTheWholeBodyHasItsShape) {
    const Body larger = body_of({"crate", Box{2.4, 2.0, 1.2}});
    const Evidence with_crate = evidence_of(view_, {{larger, truth_}});
    EXPECT_GT(shape(with_cart_, truth_), 3);
    EXPECT_LT(shape(with_crate, truth_), 0) << "what goes on beyond it to all sides is something else";
    EXPECT_GT(score(with_crate, truth_).log_ratio, 3) << "though it covers the body's pixels";
}

TEST_F(PlaceScoreOfACart, ACartBehindAnotherIsPartlyCovered) {
    const SeenBy camera{&view_, &empty_, nullptr};
    const Eigen::Vector2d away = (Eigen::Vector2d(truth_.x, truth_.y) - view_.position().head<2>()).normalized();
    const Pose2 behind{truth_.x + 0.6 * away.x(), truth_.y + 0.6 * away.y(), truth_.yaw};
    const Pose2 beside{truth_.x - 1.5 * away.y(), truth_.y + 1.5 * away.x(), truth_.yaw};
    const auto covered = [&](const Pose2& pose) { return covered_part({&camera, 1}, body_, pose, body_, truth_, memory_); };
    EXPECT_NEAR(covered(truth_), 1, 1e-9);
    EXPECT_GT(covered(behind), 0.1);
    EXPECT_LT(covered(behind), 0.9);
    EXPECT_EQ(covered(beside), 0);
}

}  // namespace
}  // namespace roomfix
