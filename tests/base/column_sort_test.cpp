#include "roomfix/base/column_sort.hpp"

#include <gtest/gtest.h>

#include "roomfix/base/random.hpp"

namespace roomfix {
namespace {

TEST(ColumnSort, SortsEachColumnByItself) {
    Random random(3);
    for (std::size_t count = 0; count < 40; ++count) {
        std::vector<ColumnRow> rows(count);
        for (ColumnRow& row : rows) {
            for (float& value : row) value = static_cast<float>(std::floor(10 * random.uniform()));  // many are equal
        }
        std::vector<ColumnRow> sorted = rows;
        sort_columns(sorted);
        for (std::size_t column = 0; column < columns_together; ++column) {
            std::vector<float> expected, got;
            for (const ColumnRow& row : rows) expected.push_back(row[column]);
            for (const ColumnRow& row : sorted) got.push_back(row[column]);
            std::sort(expected.begin(), expected.end());
            EXPECT_EQ(got, expected) << count << " rows, column " << column;
        }
    }
}

}  // namespace
}  // namespace roomfix
