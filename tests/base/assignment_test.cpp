#include "roomfix/base/assignment.hpp"

#include <gtest/gtest.h>

#include <functional>

#include "roomfix/base/random.hpp"

namespace roomfix {
namespace {

double cost_of(const std::vector<int>& column_of, const std::vector<PossiblePair>& pairs, double alone) {
    double sum = 0;
    for (std::size_t row = 0; row < column_of.size(); ++row) {
        double cost = alone;
        for (const PossiblePair& p : pairs) {
            if (p.row == static_cast<int>(row) && p.column == column_of[row]) cost = p.cost;
        }
        sum += cost;
    }
    return sum;
}

TEST(Assignment, IsAsCheapAsTheBestOfAllPossibleOnes) {
    Random random(1);
    for (int round = 0; round < 300; ++round) {
        const int rows = 1 + random.index(5), columns = 1 + random.index(5);
        std::vector<PossiblePair> pairs;
        for (int r = 0; r < rows; ++r) {
            for (int c = 0; c < columns; ++c) {
                if (random.uniform() < 0.6) pairs.push_back({r, c, random.uniform(0, 15)});
            }
        }
        const auto found = assign(rows, columns, pairs, 10);
        std::vector<int> trial(static_cast<std::size_t>(rows), -1);
        double best = 1e9;
        const std::function<void(std::size_t)> try_all = [&](std::size_t row) {
            if (row == trial.size()) {
                best = std::min(best, cost_of(trial, pairs, 10));
                return;
            }
            trial[row] = -1;
            try_all(row + 1);
            for (const PossiblePair& p : pairs) {
                if (p.row != static_cast<int>(row) ||
                    std::find(trial.begin(), trial.begin() + static_cast<std::ptrdiff_t>(row), p.column) != trial.begin() + static_cast<std::ptrdiff_t>(row))
                    continue;
                trial[row] = p.column;
                try_all(row + 1);
            }
            trial[row] = -1;
        };
        try_all(0);
        EXPECT_NEAR(cost_of(found, pairs, 10), best, 1e-9);
    }
}

TEST(Assignment, OfNothingIsNothing) {
    EXPECT_TRUE(assign(0, 3, {}, 10).empty());
    EXPECT_EQ(assign(2, 0, {}, 10), (std::vector<int>{-1, -1}));
}

}  // namespace
}  // namespace roomfix
