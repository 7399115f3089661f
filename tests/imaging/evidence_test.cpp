#include "roomfix/imaging/evidence.hpp"

#include <gtest/gtest.h>

#include <random>

namespace roomfix {
namespace {

/// Random numbers, with a patch that may be a shadow.
Evidence some_evidence() {
    Evidence evidence;
    evidence.width = 61;
    evidence.height = 47;
    std::mt19937 random(5);
    for (int i = 0; i < 61 * 47; ++i) {
        const int x = i % 61, y = i / 61;
        const bool shadow = x > 20 && x < 40 && y > 10 && y < 30;
        const auto other = static_cast<std::uint16_t>(random() % 1000);
        const auto plain = static_cast<std::uint16_t>(1600 - other);
        evidence.pixels.push_back({static_cast<std::uint16_t>(other + (shadow ? 400 : 0)), plain});
        evidence.perhaps.push_back(shadow ? 400 : 0);
    }
    evidence.sum_up();
    return evidence;
}

std::vector<int> a_body() {
    std::vector<int> covered;
    for (int y = 15; y < 25; ++y) {
        for (int x = 15; x < 25; ++x) covered.push_back(y * 61 + x);
    }
    return covered;
}

void expect_same_sums(const Evidence& a, const Evidence& b) {
    for (int y = 0; y < a.height; ++y) {
        for (int x = 0; x < a.width; x += 5) {
            EXPECT_NEAR(static_cast<double>(a.run(y, 0, x).other), static_cast<double>(b.run(y, 0, x).other), 1e-4);
            EXPECT_NEAR(static_cast<double>(a.box(0, 0, x + 1, y + 1).other), static_cast<double>(b.box(0, 0, x + 1, y + 1).other), 1e-2);
            EXPECT_NEAR(static_cast<double>(a.box(0, 0, x + 1, y + 1).plain), static_cast<double>(b.box(0, 0, x + 1, y + 1).plain), 1e-2);
        }
    }
    EXPECT_NEAR(a.clutter, b.clutter, 1e-5);
}

TEST(Evidence, WhatIsTakenAwaySaysNothingAndNorDoesItsShadow) {
    Evidence evidence = some_evidence();
    std::vector<int> covered = a_body();
    evidence.take_away(covered);
    EXPECT_TRUE(covered.empty());
    for (const int i : a_body()) EXPECT_EQ(evidence.pixels[static_cast<std::size_t>(i)], Evidence::Pixel());
    for (const int shadow : evidence.perhaps) EXPECT_EQ(shadow, 0) << "it hangs together with the body";
    Evidence anew = evidence;
    anew.sum_up();
    expect_same_sums(evidence, anew);
}

TEST(Evidence, WhatWasTakenAwayCanBePutBack) {
    const Evidence before = some_evidence();
    Evidence evidence = before;
    std::vector<int> covered = a_body();
    std::vector<Evidence::Change> pixels;
    evidence.take_away(covered, &pixels);
    evidence.put_back(pixels);
    for (std::size_t i = 0; i < before.pixels.size(); ++i) {
        EXPECT_EQ(evidence.pixels[i], before.pixels[i]);
        EXPECT_EQ(evidence.perhaps[i], before.perhaps[i]);
    }
    expect_same_sums(evidence, before);
}

TEST(Evidence, WhatMayBeAShadowCountsInPartUntilABodyIsItsReason) {
    Evidence evidence = some_evidence();
    evidence.perhaps_counts = false;
    const int before = evidence.pixels[15 * 61 + 25].other;
    evidence.weigh_shadow(15 * 61 + 25, 0.5f);
    EXPECT_EQ(evidence.pixels[15 * 61 + 25].other, before + 200);
    evidence.shadows_are_weighed();
    std::vector<int> covered = a_body();
    evidence.take_away(covered);
    EXPECT_EQ(evidence.pixels[15 * 61 + 25].other, before) << "as a part of the body's shadow";
}

}  // namespace
}  // namespace roomfix
