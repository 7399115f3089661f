#include "roomfix/smooth/smoother.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "roomfix/base/random.hpp"
#include "roomfix/evaluate/hall.hpp"

namespace roomfix {
namespace {

/// Cameras see one robot without wheels for three seconds, then nothing for 20 s, then again for three.
class LongGap {
public:
    LongGap() : site_(site()), tracker_(site_, {}) {
        tracker_.keep_history();
        Random random(8);
        for (int i = 0; i <= 260; ++i) {
            const double t = 0.1 * i;
            if (t <= 3 || t >= 23) see(t, random);
            const auto now = tracker_.fixes(from_seconds(t));
            fixes_.insert(fixes_.end(), now.begin(), now.end());
        }
    }

    /// In the middle of the gap somebody claims to know where it is.
    Fix smoothed_claim() {
        for (Fix& fix : fixes_) {
            if (std::abs(to_seconds(fix.time) - 13) > 0.04) continue;
            fix.status = FixStatus::ok;
            fix.pose = {7, 1, 0};
            fix.covariance = 1e-4 * Eigen::Matrix3d::Identity();
        }
        const Smoothed smoothed = smooth(tracker_, fixes_);
        EXPECT_TRUE(smoothed.unsettled.empty());
        for (const Fix& fix : smoothed.fixes) {
            if (std::abs(to_seconds(fix.time) - 13) < 0.04) return fix;
        }
        ADD_FAILURE() << "no fix";
        return {};
    }

    std::vector<Fix> all() { return smooth(tracker_, fixes_).fixes; }

private:
    static Site site() {
        HallSenses senses;
        senses.cameras = true;
        Site site = hall_site(senses);
        site.robots[0].odometry.reset();
        site.robots[0].receivers.clear();
        return site;
    }

    void see(double t, Random& random) {
        PoseObservation o;
        const double sigma = 0.01;
        o.pose = {3 + 0.1 * t + sigma * random.normal(), 3 + sigma * random.normal(), sigma * random.normal()};
        o.covariance = sigma * sigma * Eigen::Matrix3d::Identity();
        tracker_.observe(from_seconds(t), site_.cameras[0].id, std::vector<PoseObservation>{o});
    }

    Site site_;
    Tracker tracker_;
    std::vector<Fix> fixes_;
};

TEST(Smoother, GivesNoFixWhereAllTogetherDoesNotTellIt) {
    const Fix fix = LongGap().smoothed_claim();
    EXPECT_EQ(fix.status, FixStatus::none);
    EXPECT_NE(fix.reason.find("may be anywhere"), std::string::npos) << fix.reason;
    EXPECT_FALSE(fix.yaw_known);
}

TEST(Smoother, GivesOneWhereItWasSeen) {
    int known = 0;
    for (const Fix& fix : LongGap().all()) {
        const double t = to_seconds(fix.time);
        if (t < 1 || (t > 2.9 && t < 23.1)) continue;
        if (fix.status == FixStatus::none) continue;
        ++known;
        EXPECT_NEAR(fix.pose.x, 3 + 0.1 * t, 0.05);
        EXPECT_NEAR(fix.pose.y, 3, 0.05);
    }
    EXPECT_GT(known, 40);
}

}  // namespace
}  // namespace roomfix
