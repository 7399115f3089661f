#include "roomfix/corner/faint_edge.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "roomfix/base/random.hpp"

namespace roomfix {
namespace {

/// A half-line from (100, 60) px towards `angle`, `contrast` grey levels, in noise of two; something else, much plainer, begins `plain_from`
/// px along it.
LumaImage faint_picture(double angle, double contrast, double plain_from, Random& random) {
    LumaImage picture(640, 480);
    const Eigen::Vector2d along(std::cos(angle), std::sin(angle));
    for (int y = 0; y < 480; ++y) {
        for (int x = 0; x < 640; ++x) {
            const Eigen::Vector2d d(x - 100, y - 60);
            const double run = d.dot(along);
            const double across = along.x() * d.y() - along.y() * d.x();
            const double step = 0.5 * std::erfc(-across / 1.4);
            const double here = run > plain_from ? 20 * contrast : contrast;
            picture.row(y)[x] = static_cast<std::uint8_t>(std::lround(120 + here * step + random.normal(2)));
        }
    }
    return picture;
}

struct Seen {
    CameraModel model = make_camera_model(640, 480, 600, 600, 319.5, 239.5);
    FaintEdges edges{model};
    LightTable light;
    Eigen::Vector2d corner{(100 - 319.5) / 600, (60 - 239.5) / 600};
};

TEST(FaintEdges, ALineFainterThanTheNoiseIsFoundAlongItsWholeLength) {
    Random random(11);
    const Seen seen;
    for (int i = 0; i < 10; ++i) {
        const double angle = random.uniform(0.3, 0.9);
        const LumaImage picture = faint_picture(angle, 1.5, 1e9, random);
        const double guess = angle + random.uniform(-0.08, 0.08);
        std::vector<FaintEdges::Peak> peaks;
        seen.edges.peaks(picture, seen.light, seen.corner, {std::cos(guess), std::sin(guess)}, EdgeKind::step, 0.1, peaks);
        ASSERT_FALSE(peaks.empty());
        EXPECT_NEAR(guess + peaks[0].turn, angle, 0.006);
        EXPECT_GT(peaks[0].evidence.plain,
                  5 * seen.edges.along(picture, seen.light, seen.corner, {std::cos(angle + 0.2), std::sin(angle + 0.2)}, EdgeKind::step).plain);
    }
}

TEST(FaintEdges, WhatIsMuchPlainerBelongsToSomethingElse) {
    Random random(12);
    const Seen seen;
    const LumaImage picture = faint_picture(0.6, 2, 150, random);
    const EdgeEvidence evidence = seen.edges.along(picture, seen.light, seen.corner, {std::cos(0.6), std::sin(0.6)}, EdgeKind::step);
    EXPECT_LE(evidence.visible, 160);
    EXPECT_GE(evidence.visible, 100);
}

}  // namespace
}  // namespace roomfix
