#include "roomfix/corner/edge_contrast.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "roomfix/base/random.hpp"

namespace roomfix {
namespace {

/// Pieces of 16 px with an error of 0.5 each.
EdgeContrasts pieces_of(const std::vector<double>& contrasts, Random& random) {
    EdgeContrasts pieces;
    for (const double contrast : contrasts) pieces.push_back({contrast + random.normal(0.5), 1 / 0.25});
    return pieces;
}

TEST(EdgeContrast, AnEdgeEndsWhereAMuchPlainerOneBegins) {
    Random random(5);
    const EdgeContrasts pieces = pieces_of({5, 5, 6, 5, 30, 31, 30, 29}, random);
    const std::size_t kept = pieces_before_change(pieces, 16, {});
    EXPECT_GE(kept, 2u);
    EXPECT_LE(kept, 4u);
}

TEST(EdgeContrast, AnEdgeEndsWhereItsContrastTurnsAround) {
    Random random(6);
    const EdgeContrasts pieces = pieces_of({-9, -9, -9, -9, 12, 12, 12, 12}, random);
    const std::size_t kept = pieces_before_change(pieces, 16, {});
    EXPECT_GE(kept, 3u);
    EXPECT_LE(kept, 4u);
}

TEST(EdgeContrast, ShadingNoiseAndAFadingEdgeEndNone) {
    Random random(7);
    for (int i = 0; i < 200; ++i) {
        EXPECT_EQ(pieces_before_change(pieces_of({8, 9, 10, 12, 14, 16, 18, 20, 22, 24}, random), 16, {}), 10u) << "shading";
        EXPECT_EQ(pieces_before_change(pieces_of({0, 0, 0, 0, 0, 0, 0, 0}, random), 16, {}), 8u) << "noise";
        EXPECT_EQ(pieces_before_change(pieces_of({40, 40, 40, 2, 2, 2}, random), 16, {}), 6u) << "what fades may go on";
    }
}

TEST(EdgeContrast, PiecesThatWereNotReadSayNothing) {
    EdgeContrasts pieces;
    EXPECT_EQ(pieces_before_change(pieces, 16, {}), 0u);
    for (int i = 0; i < 5; ++i) pieces.push_back({});
    pieces.push_back({50, 4});
    EXPECT_EQ(pieces_before_change(pieces, 16, {}), 6u);
}

}  // namespace
}  // namespace roomfix
