#include "roomfix/base/assignment.hpp"

#include <algorithm>
#include <limits>
#include <numeric>

namespace roomfix {
namespace {

constexpr double endless = std::numeric_limits<double>::infinity();

/// Root of an element's group, with the paths shortened on the way.
int root(std::vector<int>& parent, int i) {
    while (parent[static_cast<std::size_t>(i)] != i) {
        auto& up = parent[static_cast<std::size_t>(i)];
        up = parent[static_cast<std::size_t>(up)];
        i = up;
    }
    return i;
}

/// Square or wide cost matrix, row-major: the column of each row. Every row gets one.
std::vector<int> assign_dense(std::size_t rows, std::size_t columns, const std::vector<double>& cost) {
    std::vector<double> row_price(rows + 1, 0), column_price(columns + 1, 0);
    std::vector<std::size_t> owner(columns + 1, 0), way(columns + 1, 0);  // 1-based; owner 0: free
    for (std::size_t row = 1; row <= rows; ++row) {
        owner[0] = row;
        std::size_t at = 0;
        std::vector<double> least(columns + 1, endless);
        std::vector<char> used(columns + 1, 0);
        do {
            used[at] = 1;
            const std::size_t i = owner[at];
            double delta = endless;
            std::size_t next = 0;
            for (std::size_t j = 1; j <= columns; ++j) {
                if (used[j]) continue;
                const double reduced = cost[(i - 1) * columns + j - 1] - row_price[i] - column_price[j];
                if (reduced < least[j]) {
                    least[j] = reduced;
                    way[j] = at;
                }
                if (least[j] < delta) {
                    delta = least[j];
                    next = j;
                }
            }
            for (std::size_t j = 0; j <= columns; ++j) {
                if (used[j]) {
                    row_price[owner[j]] += delta;
                    column_price[j] -= delta;
                } else {
                    least[j] -= delta;
                }
            }
            at = next;
        } while (owner[at] != 0);
        while (at != 0) {
            owner[at] = owner[way[at]];
            at = way[at];
        }
    }
    std::vector<int> column_of(rows, -1);
    for (std::size_t j = 1; j <= columns; ++j) {
        if (owner[j] != 0) column_of[owner[j] - 1] = static_cast<int>(j - 1);
    }
    return column_of;
}

}  // namespace

std::vector<int> assign(int rows, int columns, const std::vector<PossiblePair>& pairs, double alone) {
    std::vector<int> parent(static_cast<std::size_t>(rows + columns));
    std::iota(parent.begin(), parent.end(), 0);
    for (const PossiblePair& pair : pairs) parent[static_cast<std::size_t>(root(parent, pair.row))] = root(parent, rows + pair.column);

    // The pairs of each group together.
    std::vector<std::pair<int, std::size_t>> by_group;
    for (std::size_t i = 0; i < pairs.size(); ++i) by_group.emplace_back(root(parent, pairs[i].row), i);
    std::sort(by_group.begin(), by_group.end());
    std::vector<int> result(static_cast<std::size_t>(rows), -1);
    std::vector<int> group_rows, group_columns;
    const auto place_of = [](std::vector<int>& list, int value) {
        const auto found = std::lower_bound(list.begin(), list.end(), value);
        return static_cast<std::size_t>(found - list.begin());
    };
    const auto unique = [](std::vector<int>& list) {
        std::sort(list.begin(), list.end());
        list.erase(std::unique(list.begin(), list.end()), list.end());
    };
    for (std::size_t begin = 0; begin < by_group.size();) {
        std::size_t end = begin;
        group_rows.clear();
        group_columns.clear();
        for (; end < by_group.size() && by_group[end].first == by_group[begin].first; ++end) {
            group_rows.push_back(pairs[by_group[end].second].row);
            group_columns.push_back(pairs[by_group[end].second].column);
        }
        unique(group_rows);
        unique(group_columns);
        // Each row may also stay alone, in a column of its own.
        const std::size_t width = group_columns.size() + group_rows.size();
        constexpr double forbidden = 1e9;
        std::vector<double> cost(group_rows.size() * width, forbidden);
        for (std::size_t r = 0; r < group_rows.size(); ++r) cost[r * width + group_columns.size() + r] = alone;
        for (std::size_t i = begin; i < end; ++i) {
            const PossiblePair& pair = pairs[by_group[i].second];
            cost[place_of(group_rows, pair.row) * width + place_of(group_columns, pair.column)] = pair.cost;
        }
        const std::vector<int> chosen = assign_dense(group_rows.size(), width, cost);
        for (std::size_t r = 0; r < group_rows.size(); ++r) {
            const auto column = static_cast<std::size_t>(chosen[r]);
            if (column < group_columns.size()) result[static_cast<std::size_t>(group_rows[r])] = group_columns[column];
        }
        begin = end;
    }
    return result;
}

}  // namespace roomfix
