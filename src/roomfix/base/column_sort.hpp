// Sorts many short series of numbers at once.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

namespace roomfix {

/// Series side by side: each is a column of the rows.
constexpr std::size_t columns_together = 64;
using ColumnRow = std::array<float, columns_together>;

/// Sorts each column by itself. The steps are the same for all columns, so that several are sorted in one instruction.
/// Source: Batcher's odd-even merge sort, 1968.
inline void sort_columns(std::vector<ColumnRow>& rows) {
    const std::size_t count = rows.size();
    for (std::size_t p = 1; p < count; p *= 2) {
        for (std::size_t k = p; k >= 1; k /= 2) {
            for (std::size_t j = k % p; j + k < count; j += 2 * k) {
                for (std::size_t i = j; i < std::min(j + k, count - k); ++i) {
                    if (i / (2 * p) != (i + k) / (2 * p)) continue;
                    ColumnRow& low = rows[i];
                    ColumnRow& high = rows[i + k];
                    for (std::size_t c = 0; c < columns_together; ++c) {
                        const float a = low[c], b = high[c];
                        low[c] = a < b ? a : b;
                        high[c] = a < b ? b : a;
                    }
                }
            }
        }
    }
}

}  // namespace roomfix
