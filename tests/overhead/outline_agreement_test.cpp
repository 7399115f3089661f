#include "roomfix/overhead/outline_agreement.hpp"

#include <gtest/gtest.h>

namespace roomfix {
namespace {

SilhouetteObservation outline_at(double x, double sigma) {
    SilhouetteObservation outline;
    outline.pose = {x, 2, 0};
    outline.covariance = sigma * sigma * Eigen::Matrix3d::Identity();
    return outline;
}

TEST(OutlineAgreement, WhatIsAsNearAsItStatesSpeaksForTheSolid) {
    EXPECT_GT(nats_of_agreement(outline_at(1, 0.003), outline_at(1.004, 0.003)), 1);
    EXPECT_LE(nats_of_agreement(outline_at(1, 0.003), outline_at(1, 0.003)), 2);
}

TEST(OutlineAgreement, CentimetresApartThatStateMillimetresContradictEachOther) {
    EXPECT_LT(nats_of_agreement(outline_at(1, 0.003), outline_at(1.067, 0.003)), -11);
}

TEST(OutlineAgreement, WhatIsKnownToCentimetresTellsLittle) { EXPECT_NEAR(nats_of_agreement(outline_at(1, 0.05), outline_at(1.06, 0.05)), 0, 0.8); }

}  // namespace
}  // namespace roomfix
