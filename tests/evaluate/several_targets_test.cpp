// GOSPA, IDF1 and HOTA beside values that were worked out by hand.
#include <gtest/gtest.h>

#include <cmath>

#include "evaluate/tracks.hpp"
#include "roomfix/evaluate/gospa.hpp"
#include "roomfix/evaluate/hota.hpp"
#include "roomfix/evaluate/idf1.hpp"

namespace roomfix {
namespace {

TEST(SeveralTargets, PerfectTracksHaveNoErrorAndFullScores) {
    std::vector<Fix> fixes;
    follow(fixes, "r1", 0);
    follow(fixes, "r2", 3);
    const Moments moments = moments_with(fixes, side_by_side());
    EXPECT_EQ(moments.all.size(), 100U);
    EXPECT_NEAR(gospa_of(moments).mean, 0, 1e-12);
    EXPECT_NEAR(gospa_of(moments).rms, 0, 1e-12);
    EXPECT_EQ(identity_score(moments).f1(), 1);
    EXPECT_NEAR(hota_of(moments).hota, 1, 1e-12);
}

TEST(SeveralTargets, NamesThatSwapHalfWayHalveTheIdentitiesAndNotTheDetections) {
    const Moments moments = moments_with(swapped_halves(), side_by_side());
    EXPECT_NEAR(gospa_of(moments).rms, 0, 1e-12) << "GOSPA does not look at names";
    EXPECT_EQ(identity_score(moments).true_positives, 100U);
    EXPECT_NEAR(identity_score(moments).f1(), 0.5, 1e-12);
    const Hota hota = hota_of(moments);
    EXPECT_NEAR(hota.detection, 1, 1e-12);
    EXPECT_NEAR(hota.association, 50.0 / 150, 1e-12) << "each pair is together for 50 of the 150 moments of either";
    EXPECT_NEAR(hota.hota, std::sqrt(1.0 / 3), 1e-12);
}

TEST(SeveralTargets, IdentitiesAreAssignedOnceForTheWholeSession) {
    std::vector<Fix> fixes;
    follow(fixes, "a", 0, 0, 60);
    follow(fixes, "a", 3, 60, 100);
    follow(fixes, "b", 0, 60, 90);
    const IdentityScore score = identity_score(moments_with(fixes, side_by_side()));
    // a on r2 and b on r1 are 40 + 30; a on r1, which it is on for longest, leaves b nothing and gives 60.
    EXPECT_EQ(score.true_positives, 70U);
    EXPECT_EQ(score.false_positives, 60U);
    EXPECT_EQ(score.false_negatives, 130U);
    EXPECT_NEAR(score.precision(), 70.0 / 130, 1e-12);
    EXPECT_NEAR(score.recall(), 70.0 / 200, 1e-12);
    EXPECT_NEAR(score.f1(), 140.0 / 330, 1e-12);
}

TEST(SeveralTargets, AMissedTargetCostsHalfTheSquaredCutOff) {
    std::vector<Fix> fixes;
    follow(fixes, "r1", 0);
    const Moments moments = moments_with(fixes, side_by_side(), 2);
    const Gospa gospa = gospa_of(moments);
    EXPECT_NEAR(gospa.mean, std::sqrt(2.0), 1e-12);
    EXPECT_NEAR(gospa.missed, std::sqrt(2.0), 1e-12);
    EXPECT_EQ(gospa.missed_at_once, 1);
    EXPECT_EQ(gospa.false_at_once, 0);
    EXPECT_NEAR(identity_score(moments).f1(), 2.0 / 3, 1e-12);
    EXPECT_NEAR(hota_of(moments).detection, 0.5, 1e-12);
    EXPECT_NEAR(hota_of(moments).association, 1, 1e-12);
    EXPECT_NEAR(hota_of(moments).hota, std::sqrt(0.5), 1e-12);
}

TEST(SeveralTargets, AFalseTrackCostsAsMuchForAsLongAsItIsThere) {
    std::vector<Fix> fixes;
    follow(fixes, "r1", 0);
    follow(fixes, "r2", 3);
    follow(fixes, "r3", 9, 0, 25);
    const Moments moments = moments_with(fixes, side_by_side());
    const Gospa gospa = gospa_of(moments);
    EXPECT_NEAR(gospa.mean, 0.25 * std::sqrt(0.5), 1e-12);
    EXPECT_NEAR(gospa.rms, std::sqrt(0.25 * 0.5), 1e-12);
    EXPECT_NEAR(gospa.false_ones, gospa.rms, 1e-12);
    EXPECT_EQ(gospa.false_at_once, 0.25);
    EXPECT_NEAR(identity_score(moments).precision(), 200.0 / 225, 1e-12);
    EXPECT_NEAR(hota_of(moments).detection, 200.0 / 225, 1e-12);
}

TEST(SeveralTargets, GospaIsTheRootOfThePartsOfOneMoment) {
    const std::vector<Fix> fixes = {ok_fix(0, "a", 0.3, 0.4), ok_fix(0, "b", 9, 9)};
    const Gospa gospa = gospa_of(moments_with(fixes, side_by_side(1)));
    EXPECT_NEAR(gospa.mean, std::sqrt(0.25 + 0.5 + 0.5), 1e-12);
    EXPECT_NEAR(gospa.rms, gospa.mean, 1e-12);
    EXPECT_NEAR(gospa.localisation, 0.5, 1e-12);
    EXPECT_NEAR(gospa.missed, std::sqrt(0.5), 1e-12);
    EXPECT_NEAR(gospa.false_ones, std::sqrt(0.5), 1e-12);
}

TEST(SeveralTargets, GospaTakesTheBestPairsAndNotTheNearestFirst) {
    Truth truth;
    truth["r1"] = {{0, {0, 0, 0}}};
    truth["r2"] = {{0, {0.6, 0, 0}}};
    // The nearest pair, 0.1 m, would leave a missed and a false one: 0.01 + 1.
    const std::vector<Fix> fixes = {ok_fix(0, "a", 0.5, 0), ok_fix(0, "b", 1.3, 0)};
    EXPECT_NEAR(gospa_of(moments_with(fixes, truth)).mean, std::sqrt(0.25 + 0.49), 1e-12);
}

TEST(SeveralTargets, HotaCountsAnOffsetAtTheThresholdsThatAllowIt) {
    std::vector<Fix> fixes;
    follow(fixes, "r1", 0.3);
    follow(fixes, "r2", 3.3);
    const Hota at_one = hota_of(moments_with(fixes, side_by_side(), 1));
    EXPECT_NEAR(at_one.hota, 14.0 / 19, 1e-9) << "similarity 0.7: thresholds 0.05 to 0.70";
    EXPECT_NEAR(at_one.detection, 14.0 / 19, 1e-9);
    EXPECT_NEAR(at_one.association, 14.0 / 19, 1e-9);
    EXPECT_NEAR(hota_of(moments_with(fixes, side_by_side(), 2)).hota, 17.0 / 19, 1e-9) << "similarity 0.85";
    EXPECT_EQ(hota_of(moments_with(fixes, side_by_side(), 0.2)).hota, 0);
}

TEST(SeveralTargets, HotaKeepsTogetherWhatIsTogetherForLong) {
    Truth truth;
    drive(truth, "r1", 0, 10);
    drive(truth, "r2", 0.2, 10);
    std::vector<Fix> fixes;
    follow(fixes, "r1", 0, 0, 9);
    follow(fixes, "r2", 0.2, 0, 9);
    follow(fixes, "r1", 0.12, 9, 10);  // 0.12 m from its own, 0.08 m from the other
    follow(fixes, "r2", 0.08, 9, 10);
    const Hota hota = hota_of(moments_with(fixes, truth));
    // Matched are their own at all moments: the last one's are similar by 0.88, up to alpha 0.85.
    EXPECT_NEAR(hota.detection, (17 + 2 * 18.0 / 22) / 19, 1e-9);
    EXPECT_NEAR(hota.association, (17 + 2 * 9.0 / 11) / 19, 1e-9);
}

TEST(Moments, TheAgeOfAFixIsNoErrorUntilItIsTooOld) {
    const Truth truth = side_by_side(10);
    const std::vector<Fix> fixes = {ok_fix(0.15, "r1", 0.15, 0)};
    const Moments moments = moments_of(fixes, truth, times_of(truth), 1, 0.25);
    std::vector<int> there;
    for (std::size_t i = 0; i < moments.all.size(); ++i) {
        if (!moments.all[i].tracks.empty()) there.push_back(static_cast<int>(i));
        for (const CloseBy& pair : moments.all[i].pairs) EXPECT_NEAR(pair.distance, 0, 1e-9);
    }
    EXPECT_EQ(there, (std::vector<int>{2, 3, 4}));
}

TEST(Moments, AFixOfStatusNoneEndsItsNameAndOneWithoutANameIsNobodys) {
    const Truth truth = side_by_side(3);
    std::vector<Fix> fixes = {ok_fix(0, "r1", 0, 0), ok_fix(0, "", 0, 3), ok_fix(0.1, "r1", 0.1, 0)};
    fixes.back().status = FixStatus::none;
    const Moments moments = moments_of(fixes, truth, times_of(truth), 1, 1);
    ASSERT_EQ(moments.tracks, std::vector<std::string>{"r1"});
    EXPECT_EQ(moments.all[0].tracks.size(), 1U);
    EXPECT_TRUE(moments.all[1].tracks.empty());
}

TEST(Moments, AreEmptyWithoutATruth) {
    const Moments moments = moments_with({ok_fix(0, "r1", 0, 0)}, {});
    EXPECT_EQ(gospa_of(moments).mean, 0);
    EXPECT_EQ(identity_score(moments).f1(), 0);
    EXPECT_EQ(hota_of(moments).hota, 0);
}

}  // namespace
}  // namespace roomfix
