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
    const auto part = [&] { return static_cast<float>(random() % 1000) / 1000; };
    for (int i = 0; i < 61 * 47; ++i) {
        const int x = i % 61, y = i / 61;
        const bool shadow = x > 20 && x < 40 && y > 10 && y < 30;
        const float other = 0.5f * part();
        evidence.pixels.push_back({other + (shadow ? 0.2f : 0), 1 - other - 0.2f});
        evidence.perhaps.push_back(shadow ? 0.2f : 0);
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
    for (const int i : a_body()) {
        EXPECT_EQ(evidence.pixels[static_cast<std::size_t>(i)].other, 0.0f);
        EXPECT_EQ(evidence.pixels[static_cast<std::size_t>(i)].plain, 0.0f);
    }
    for (const float shadow : evidence.perhaps) EXPECT_EQ(shadow, 0.0f) << "it hangs together with the body";
    Evidence anew = evidence;
    anew.sum_up();
    expect_same_sums(evidence, anew);
}

TEST(Evidence, WhatWasTakenAwayCanBePutBack) {
    const Evidence before = some_evidence();
    Evidence evidence = before;
    std::vector<int> covered = a_body();
    std::vector<Evidence::Pixel> pixels;
    evidence.take_away(covered, &pixels);
    evidence.put_back(pixels);
    for (std::size_t i = 0; i < before.pixels.size(); ++i) {
        EXPECT_EQ(evidence.pixels[i].other, before.pixels[i].other);
        EXPECT_EQ(evidence.pixels[i].plain, before.pixels[i].plain);
        EXPECT_EQ(evidence.perhaps[i], before.perhaps[i]);
    }
    expect_same_sums(evidence, before);
}

TEST(Evidence, WhatMayBeAShadowCountsOnlyOnce) {
    Evidence evidence = some_evidence();
    evidence.perhaps_counts = false;
    const float before = evidence.pixels[15 * 61 + 25].other;
    evidence.count_perhaps();
    evidence.count_perhaps();
    EXPECT_FLOAT_EQ(evidence.pixels[15 * 61 + 25].other, before + 0.2f);
}

}  // namespace
}  // namespace roomfix
