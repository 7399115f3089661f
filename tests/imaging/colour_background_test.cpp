#include "roomfix/imaging/colour_background.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace roomfix {
namespace {

constexpr int floor_width = 192;
constexpr int floor_height = 144;

/// A wooden floor with boards and grain, under a light per channel; `paint` may change the light of a pixel or its colour.
template <class Paint>
ColourImage floor_picture(unsigned seed, const Paint& paint) {
    ColourImage image{floor_width, floor_height, 3, 1, {}};
    image.values.resize(image.pixels() * 3);
    std::mt19937 grain(7);
    std::mt19937 noise(seed);
    for (int y = 0; y < floor_height; ++y) {
        for (int x = 0; x < floor_width; ++x) {
            const double wood = 1 + 0.15 * ((x / 16 + y / 48) % 2) + 0.04 * (static_cast<double>(grain() % 1000) / 500 - 1);
            double colour[3] = {60 * wood, 100 * wood, 130 * wood};
            paint(x, y, colour);
            for (int c = 0; c < 3; ++c) {
                const double value = colour[c] + 2 * (static_cast<double>(noise() % 1000) / 500 - 1);
                image.values[3 * (static_cast<std::size_t>(y) * floor_width + static_cast<std::size_t>(x)) + static_cast<std::size_t>(c)] =
                    static_cast<std::uint8_t>(std::clamp(value, 0.0, 255.0));
            }
        }
    }
    return image;
}

void nothing(int, int, double*) {}

bool in_square(int x, int y) { return x >= 80 && x < 110 && y >= 60 && y < 90; }

ColourBackground learned() {
    std::vector<ColourImage> frames;
    for (unsigned i = 0; i < 7; ++i) frames.push_back(floor_picture(i, nothing));
    ColourBackground background;
    background.learn(frames);
    return background;
}

/// Part of the square's, or of all other pixels, that show something else.
double other_part(const Evidence& evidence, bool inside) {
    double sum = 0;
    double count = 0;
    for (int y = 0; y < floor_height; ++y) {
        for (int x = 0; x < floor_width; ++x) {
            if (in_square(x, y) != inside) continue;
            sum += static_cast<double>(evidence.at(static_cast<std::size_t>(y * floor_width + x)).other);
            ++count;
        }
    }
    return sum / count;
}

TEST(EvidenceOfColours, ExposureAndWhiteBalanceAreNoForeground) {
    auto background = learned();
    Evidence evidence;
    ASSERT_TRUE(background.compare(floor_picture(99,
                                                 [](int x, int, double* c) {
                                                     const double lamp = 1 + 0.2 * x / floor_width;
                                                     c[0] *= 0.8 * lamp, c[1] *= 0.7 * lamp, c[2] *= 0.6 * lamp;
                                                 }),
                                   evidence));
    EXPECT_LT(evidence.clutter, 0.01);
}

TEST(EvidenceOfColours, AShadowSaysNothingAndAnotherColourDoes) {
    auto background = learned();
    Evidence evidence;
    ASSERT_TRUE(background.compare(floor_picture(99,
                                                 [](int x, int y, double* c) {
                                                     for (int k = 0; k < 3 && in_square(x, y); ++k) c[k] *= 0.55;
                                                 }),
                                   evidence));
    EXPECT_LT(other_part(evidence, true), 0.1);
    ASSERT_TRUE(background.compare(floor_picture(99,
                                                 [](int x, int y, double* c) {
                                                     if (in_square(x, y)) c[0] = 150, c[1] = 90, c[2] = 40;
                                                 }),
                                   evidence));
    EXPECT_GT(other_part(evidence, true), 0.9);
    EXPECT_LT(other_part(evidence, false), 0.01);
}

TEST(EvidenceOfColours, GreyFramesAreComparedInGrey) {
    auto background = learned();
    Evidence evidence;
    auto frame = floor_picture(99, [](int x, int y, double* c) {
        for (int k = 0; k < 3 && in_square(x, y); ++k) c[k] = 8;
    });
    make_grey(frame);
    ASSERT_TRUE(background.compare(frame, evidence));
    EXPECT_GT(other_part(evidence, true), 0.6);
    EXPECT_LT(other_part(evidence, false), 0.01);
}

TEST(EvidenceOfColours, AFrameOfAnotherSizeIsRefused) {
    auto background = learned();
    Evidence evidence;
    ColourImage small{16, 16, 3, 1, std::vector<std::uint8_t>(16 * 16 * 3, 90)};
    EXPECT_FALSE(background.compare(small, evidence));
}

TEST(EvidenceOfColours, SumsAreThoseOfThePixels) {
    auto background = learned();
    Evidence evidence;
    ASSERT_TRUE(background.compare(floor_picture(5,
                                                 [](int x, int y, double* c) {
                                                     if (in_square(x, y)) c[0] = 200;
                                                 }),
                                   evidence));
    double plain = 0;
    double other = 0;
    for (int y = 20; y < 100; ++y) {
        for (int x = 28; x < 152; ++x) {  // all cells that the box touches
            const auto p = evidence.at(static_cast<std::size_t>(y * floor_width + x));
            plain += static_cast<double>(p.plain);
            other += static_cast<double>(p.other);
        }
    }
    const auto box = evidence.box(30, 20, 150, 100);
    EXPECT_NEAR(static_cast<double>(box.plain), plain, 1);
    EXPECT_NEAR(static_cast<double>(box.other), other, 1);
}

TEST(KeptFrames, AreSpreadEvenlyAndNeverMoreThanAsked) {
    ColourFrames kept(8);
    for (int i = 0; i < 100; ++i) kept.add({1, 1, 1, 1, {static_cast<std::uint8_t>(i)}});
    ASSERT_LE(kept.frames().size(), 8U);
    ASSERT_GE(kept.frames().size(), 4U);
    EXPECT_EQ(kept.frames()[0].values[0], 0) << "the first frame stays";
    EXPECT_GT(kept.frames().back().values[0], 80);
}

}  // namespace
}  // namespace roomfix
