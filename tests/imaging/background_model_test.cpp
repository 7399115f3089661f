#include "roomfix/imaging/background_model.hpp"

#include <gtest/gtest.h>

#include "roomfix/base/random.hpp"
#include "roomfix/imaging/background_rows.hpp"

namespace roomfix {
namespace {

std::vector<std::uint8_t> random_bytes(std::size_t count, int low, int high, Random& random) {
    std::vector<std::uint8_t> bytes(count);
    for (auto& b : bytes) b = static_cast<std::uint8_t>(low + random.index(high - low + 1));
    return bytes;
}

TEST(BackgroundRows, SimdAndScalarAgreeBitForBit) {
    Random random(4);
    for (int i = 0; i < 300; ++i) {
        const int words = 1 + random.index(7);
        const auto count = static_cast<std::size_t>(words) * 64;
        const auto frame = random_bytes(count, 0, 255, random);
        auto mean = random_bytes(count, 0, 255, random);
        for (std::size_t k = 0; k < count; k += 3) mean[k] = frame[k];
        auto limit = random_bytes(count, i % 2 ? 0 : 10, i % 3 ? 40 : 255, random);
        std::vector<std::uint16_t> gain(static_cast<std::size_t>(words));
        for (auto& g : gain) g = static_cast<std::uint16_t>(i % 5 ? 900 + random.index(250) : 1 + random.index(60000));
        const BackgroundRow row{frame.data(), mean.data(), limit.data(), gain.data(), words};
        std::vector<std::uint64_t> a(gain.size()), b(gain.size());
        simd::classify_row(row, a.data());
        scalar::classify_row(row, b.data());
        ASSERT_EQ(a, b) << "classify " << i;

        const auto above = random_bytes(count, 0, 255, random);
        const auto below = random_bytes(count, 0, 255, random);
        const simd::ShadowRow shadow{row, above.data(), below.data(), mean.data(), mean.data(), 22938};
        std::vector<std::uint64_t> c(gain.size()), d(gain.size());
        simd::shadow_row(shadow, 0, words, a.data(), c.data());
        scalar::shadow_row(shadow, 0, words, a.data(), d.data());
        ASSERT_EQ(c, d) << "shadow " << i;

        std::vector<PairSum> e(gain.size()), f(gain.size());
        const BlockRows block{{frame.data(), above.data()}, {mean.data(), below.data()}, 2, words};
        simd::block_sums(block, e.data());
        scalar::block_sums(block, f.data());
        for (std::size_t k = 0; k < e.size(); ++k) ASSERT_TRUE(e[k].frame == f[k].frame && e[k].background == f[k].background);

        std::vector<std::uint16_t> mean_fine(count), deviation(count), inverse(gain.size());
        for (std::size_t k = 0; k < count; ++k) {
            mean_fine[k] = static_cast<std::uint16_t>(mean[k] * 256 + random.index(256));
            deviation[k] = static_cast<std::uint16_t>(random.index(4096));
        }
        for (auto& g : inverse) g = static_cast<std::uint16_t>(20000 + random.index(40000));
        auto mean_fine2 = mean_fine;
        auto deviation2 = deviation;
        auto mean2 = mean;
        auto limit2 = limit;
        simd::refresh_row({frame.data(), a.data(), inverse.data(), mean_fine.data(), deviation.data(), mean.data(), limit.data(), words, 2, 4, 1605, 3});
        scalar::refresh_row({frame.data(), a.data(), inverse.data(), mean_fine2.data(), deviation2.data(), mean2.data(), limit2.data(), words, 2, 4, 1605, 3});
        ASSERT_EQ(mean_fine, mean_fine2);
        ASSERT_EQ(deviation, deviation2);
        ASSERT_EQ(mean, mean2);
        ASSERT_EQ(limit, limit2);
    }
}

/// A textured floor with noise of 2 grey levels, all of it brighter by `gain`.
LumaImage floor_frame(double gain, Random& random) {
    LumaImage image(200, 120);
    for (int y = 0; y < 120; ++y) {
        for (int x = 0; x < 200; ++x) {
            const double grey = 110 + 30 * ((x / 20 + y / 20) % 2) + 0.1 * x;
            image.row(y)[x] = static_cast<std::uint8_t>(std::clamp(std::lround(gain * grey + random.normal(2)), 0L, 255L));
        }
    }
    return image;
}

BackgroundModel learned(Random& random) {
    BackgroundLearner learner;
    for (int i = 0; i < 30; ++i) learner.add(floor_frame(random.uniform(0.97, 1.03), random));
    return learner.learn();
}

TEST(BackgroundModel, LightChangesAreNotForeground) {
    Random random(1);
    const BackgroundModel model = learned(random);
    Foreground foreground;
    for (const double gain : {0.8, 0.95, 1.0, 1.15, 1.3}) {
        model.classify(floor_frame(gain, random), foreground);
        EXPECT_LT(foreground.mask.count(), 24) << "one in a thousand at gain " << gain;
        EXPECT_NEAR(static_cast<double>(foreground.global_gain), gain, 0.015);
    }
}

TEST(BackgroundModel, AnObjectIsForegroundAndAShadowIsCalledOne) {
    Random random(2);
    const BackgroundModel model = learned(random);
    LumaImage frame = floor_frame(1.0, random);
    for (int y = 20; y < 60; ++y) {
        for (int x = 30; x < 70; ++x) frame.row(y)[x] = static_cast<std::uint8_t>(30 + random.index(4));
        for (int x = 110; x < 150; ++x) frame.row(y)[x] = static_cast<std::uint8_t>(std::lround(0.6 * frame.row(y)[x]));
    }
    Foreground foreground;
    model.classify(frame, foreground);
    int object = 0, object_shadow = 0, shadow = 0, shadow_shadow = 0;
    for (int y = 24; y < 56; ++y) {
        object += foreground.mask.count_run(y, 34, 66);
        object_shadow += foreground.shadow.count_run(y, 34, 66);
        shadow += foreground.mask.count_run(y, 114, 146);
        shadow_shadow += foreground.shadow.count_run(y, 114, 146);
    }
    EXPECT_GT(object, 0.99 * 32 * 32);
    EXPECT_LT(object_shadow, 0.02 * 32 * 32);
    EXPECT_GT(shadow, 0.99 * 32 * 32);
    EXPECT_GT(shadow_shadow, 0.95 * 32 * 32);
}

TEST(BackgroundModel, SolidForegroundIsClassifiedThenOpened) {
    Random random(11);
    for (int i = 0; i < 200; ++i) {
        const int width = 1 + random.index(210);
        const int height = 1 + random.index(50);
        const auto count = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
        const BackgroundModel model(width, height, std::vector<float>(count, 100.0f), std::vector<float>(count, 2.0f));
        LumaImage frame(width, height);
        const int speckle = 2 + random.index(20);
        for (int y = 0; y < height; ++y) {
            for (int x = 0; x < width; ++x) frame.row(y)[x] = random.index(speckle) == 0 ? 160 : 100;
        }
        for (int k = random.index(6); k > 0; --k) {  // pieces of all sizes, thinner ones than three pixels too, some cut by the border
            const int left = random.index(width);
            const int top = random.index(height);
            const int right = std::min(left + random.index(12), width);
            const int bottom = std::min(top + random.index(12), height);
            for (int y = top; y < bottom; ++y) std::fill(frame.row(y) + left, frame.row(y) + right, std::uint8_t{200});
        }
        Foreground whole, solid;
        model.classify(frame, whole);
        BitMask scratch;
        open(whole.mask, scratch);
        for (int again = 0; again < 2; ++again) model.classify_solid(frame, solid);  // what is left in its memory must not matter
        for (int y = 0; y < height; ++y) {
            for (int x = 0; x < width; ++x)
                ASSERT_EQ(solid.mask.at(x, y), whole.mask.at(x, y)) << i << ": " << x << ' ' << y << " of " << width << " x " << height;
        }
    }
}

TEST(BackgroundModel, WhatIsTooFaintForSinglePixelsShowsInTheirMean) {
    Random random(12);
    const BackgroundModel model = learned(random);
    LumaImage frame = floor_frame(1.0, random);
    for (int y = 40; y < 80; ++y) {
        for (int x = 80; x < 120; ++x) frame.row(y)[x] = static_cast<std::uint8_t>(frame.row(y)[x] - 12);
    }
    Foreground foreground;
    model.classify(frame, foreground);
    const auto inside = [&] {
        int sum = 0;
        for (int y = 44; y < 76; ++y) sum += foreground.mask.count_run(y, 84, 116);
        return sum;
    };
    EXPECT_LT(inside(), 0.4 * 32 * 32);
    model.add_faint(frame, 0, 0, 199, 119, foreground);
    EXPECT_GT(inside(), 0.95 * 32 * 32);
    int outside = 0;
    for (int y = 0; y < 120; ++y) outside += foreground.mask.count_run(y, 0, 76) + foreground.mask.count_run(y, 124, 200);
    EXPECT_LT(outside, 24);
}

TEST(BackgroundModel, LearnsUnderPassingObjects) {
    Random random(3);
    BackgroundLearner learner;
    for (int i = 0; i < 40; ++i) {
        LumaImage frame = floor_frame(1.0, random);
        for (int y = 40; y < 80; ++y) std::memset(frame.row(y) + 5 * i, 20, 15);
        learner.add(frame);
    }
    Foreground foreground;
    learner.learn().classify(floor_frame(1.0, random), foreground);
    EXPECT_LT(foreground.mask.count(), 24);
}

TEST(BackgroundModel, RefreshFollowsTheFloorButNotWhatIsKept) {
    Random random(4);
    BackgroundModel model = learned(random);
    Foreground foreground;
    BitMask keep(200, 120);
    for (int y = 0; y < 120; ++y) keep.set_run(y, 100, 200);
    const int before_kept = model.mean().at(150, 60);
    const int before_free = model.mean().at(50, 60);
    for (int i = 0; i < 64 * 20; ++i) {
        LumaImage frame = floor_frame(1.0, random);
        for (int y = 0; y < 120; ++y) {
            for (int x = 40; x < 60; ++x) frame.row(y)[x] = static_cast<std::uint8_t>(std::min(frame.row(y)[x] + 12, 255));
        }
        model.classify(frame, foreground);
        model.refresh(frame, foreground, keep);
    }
    EXPECT_EQ(model.passes(), 21);
    EXPECT_NEAR(model.mean().at(50, 60), before_free + 12, 3);
    EXPECT_EQ(model.mean().at(150, 60), before_kept);
}

}  // namespace
}  // namespace roomfix
