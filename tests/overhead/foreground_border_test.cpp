#include "roomfix/overhead/foreground_border.hpp"

#include <gtest/gtest.h>

#include <cstring>

namespace roomfix {
namespace {

/// A square outline, px.
Silhouette square(double left, double top, double size) {
    Silhouette s;
    s.count = 4;
    s.corners[0] = {left, top};
    s.corners[1] = {left + size, top};
    s.corners[2] = {left + size, top + size};
    s.corners[3] = {left, top + size};
    return s;
}

/// A square of foreground on an even floor; right of column 100 the floor is darker.
class Border : public ::testing::Test {
protected:
    Border() : mask_(160, 120), shadow_(160, 120), floor_(160, 120) {
        for (int y = 40; y <= 80; ++y) mask_.set_run(y, 60, 101);
        for (int y = 0; y < 120; ++y) {
            std::memset(floor_.row(y), 150, 160);
            std::memset(floor_.row(y) + 101, 90, 59);
        }
    }
    ForegroundBorder border() {
        ForegroundBorder made;
        made.compute(mask_, shadow_, floor_, 0, 0, 159, 119);
        return made;
    }
    BitMask mask_, shadow_;
    LumaImage floor_;
};

TEST_F(Border, ItsOwnOutlineExplainsItAll) { EXPECT_EQ(border().unexplained(square(60, 40, 40)), 0); }

TEST_F(Border, AnEdgeOfTheRoomNeedsNoOutline) {
    // The right-hand side lies on the floor's own edge: perhaps something dark stands in front of the robot there.
    const double wider = border().unexplained(square(60, 40, 80));
    EXPECT_LT(wider, 0.30) << "only the lower side is left";
    EXPECT_GT(border().unexplained(square(70, 45, 40)), 0.45) << "three sides are left";
}

TEST_F(Border, AShadowsBorderNeedsNoOutlineOutsideOfTheRobot) {
    for (int y = 81; y <= 95; ++y) {
        mask_.set_run(y, 60, 101);
        shadow_.set_run(y, 60, 101);
    }
    EXPECT_LT(border().unexplained(square(60, 40, 40)), 0.02);
    EXPECT_GT(border().unexplained(square(60, 40, 65)), 0.15) << "a robot as large as that would end lower";
}

TEST_F(Border, DistanceLeavesOutTheRoomsOwnEdges) {
    const ForegroundBorder found = border();
    BorderDistance distance;
    distance.compute(found, 160, 120, 60, 40, 101, 80, 12);
    EXPECT_EQ(distance.at({60, 60}), 0.0f);
    EXPECT_NEAR(distance.at({65, 60}), 5.0f, 0.01f);
    EXPECT_GT(distance.at({100, 60}), 10.0f);
    EXPECT_GT(distance.at({10, 10}), 1000.0f) << "not computed there";
}

}  // namespace
}  // namespace roomfix
