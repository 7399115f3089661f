#include "roomfix/imaging/bit_mask.hpp"

#include <gtest/gtest.h>

#include <functional>

#include "roomfix/base/random.hpp"
#include "roomfix/imaging/components.hpp"

namespace roomfix {
namespace {

BitMask random_mask(int width, int height, double density, Random& random) {
    BitMask mask(width, height);
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            if (random.uniform() < density) mask.set(x, y);
        }
    }
    return mask;
}

bool morphed(const BitMask& mask, int x, int y, bool erosion) {
    bool all = true;
    bool any = false;
    for (int v = y - 1; v <= y + 1; ++v) {
        for (int u = x - 1; u <= x + 1; ++u) {
            if (u < 0 || v < 0 || u >= mask.width() || v >= mask.height()) continue;
            all &= mask.at(u, v);
            any |= mask.at(u, v);
        }
    }
    return erosion ? all : any;
}

TEST(BitMask, ErosionAndDilationAreWhatTheyAreByPixel) {
    Random random(5);
    for (const int width : {1, 3, 63, 64, 65, 130, 200}) {
        for (const double density : {0.02, 0.4, 0.9, 1.0}) {
            const BitMask mask = random_mask(width, 17, density, random);
            BitMask eroded, dilated;
            erode(mask, eroded);
            dilate(mask, dilated);
            for (int y = 0; y < 17; ++y) {
                for (int x = 0; x < width; ++x) {
                    ASSERT_EQ(eroded.at(x, y), morphed(mask, x, y, true)) << width << " " << x << "," << y;
                    ASSERT_EQ(dilated.at(x, y), morphed(mask, x, y, false)) << width << " " << x << "," << y;
                }
            }
            // Reused memory must not remember: the same again into the same mask.
            const BitMask second = random_mask(width, 17, density / 2, random);
            dilate(second, dilated);
            for (int y = 0; y < 17; ++y) {
                for (int x = 0; x < width; ++x) ASSERT_EQ(dilated.at(x, y), morphed(second, x, y, false));
            }
        }
    }
}

TEST(BitMask, RunsAreCountedSetAndCleared) {
    Random random(6);
    BitMask mask = random_mask(150, 4, 0.5, random);
    for (int i = 0; i < 300; ++i) {
        const int begin = random.index(170) - 10;
        const int end = begin + random.index(120);
        int expected = 0;
        for (int x = std::max(begin, 0); x < std::min(end, 150); ++x) expected += mask.at(x, 2);
        ASSERT_EQ(mask.count_run(2, begin, end), expected);
    }
    mask.clear_run(2, -5, 90);
    EXPECT_EQ(mask.count_run(2, 0, 90), 0);
    mask.set_run(2, 30, 200);
    EXPECT_EQ(mask.count_run(2, 0, 150), 120);
}

TEST(Components, AgreeWithAFloodFill) {
    Random random(8);
    for (const double density : {0.1, 0.35, 0.5, 0.7}) {
        const int width = 131;
        const int height = 40;
        const BitMask mask = random_mask(width, height, density, random);
        ComponentFinder finder;
        const auto& found = finder.find(mask, 1);
        std::vector<int> seen(static_cast<std::size_t>(width * height), 0);
        std::vector<std::int64_t> areas;
        double sum_x = 0;
        for (int y = 0; y < height; ++y) {
            for (int x = 0; x < width; ++x) {
                if (!mask.at(x, y) || seen[static_cast<std::size_t>(y * width + x)]) continue;
                std::vector<std::pair<int, int>> stack{{x, y}};
                seen[static_cast<std::size_t>(y * width + x)] = 1;
                std::int64_t area = 0;
                while (!stack.empty()) {
                    const auto [u, v] = stack.back();
                    stack.pop_back();
                    ++area;
                    sum_x += u;
                    for (int dv = -1; dv <= 1; ++dv) {
                        for (int du = -1; du <= 1; ++du) {
                            const int a = u + du;
                            const int b = v + dv;
                            if (a < 0 || b < 0 || a >= width || b >= height || !mask.at(a, b)) continue;
                            int& mark = seen[static_cast<std::size_t>(b * width + a)];
                            if (!mark) stack.emplace_back(a, b);
                            mark = 1;
                        }
                    }
                }
                areas.push_back(area);
            }
        }
        std::sort(areas.rbegin(), areas.rend());
        ASSERT_EQ(found.size(), areas.size());
        double found_x = 0;
        for (std::size_t i = 0; i < areas.size(); ++i) {
            ASSERT_EQ(found[i].area, areas[i]);
            found_x += found[i].centroid.x() * static_cast<double>(found[i].area);
        }
        EXPECT_NEAR(found_x, sum_x, 1e-6);
    }
}

TEST(Components, MomentsOfARectangle) {
    BitMask mask(200, 100);
    for (int y = 10; y <= 29; ++y) mask.set_run(y, 60, 140);
    ComponentFinder finder;
    const auto& found = finder.find(mask, 10);
    ASSERT_EQ(found.size(), 1U);
    EXPECT_EQ(found[0].left, 60);
    EXPECT_EQ(found[0].right, 139);
    EXPECT_NEAR(found[0].centroid.x(), 99.5, 1e-9);
    EXPECT_NEAR(found[0].covariance(0, 0), (80.0 * 80 - 1) / 12, 1e-6);
    EXPECT_NEAR(found[0].covariance(1, 1), (20.0 * 20 - 1) / 12, 1e-6);
}

}  // namespace
}  // namespace roomfix
