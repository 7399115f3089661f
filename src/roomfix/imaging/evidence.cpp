#include "roomfix/imaging/evidence.hpp"

#include <algorithm>
#include <array>

namespace roomfix {

void Evidence::count_perhaps() {
    if (perhaps_counts) return;
    for (std::size_t i = 0; i < perhaps.size(); ++i) pixels[i].other += perhaps[i];
    perhaps_counts = true;
}

void Evidence::copy_pixels(const Evidence& other) {
    width = other.width;
    height = other.height;
    scale = other.scale;
    pixels = other.pixels;
    perhaps = other.perhaps;
    perhaps.resize(pixels.size());  // none where nobody said what may be a shadow
    perhaps_counts = other.perhaps_counts;
    perhaps_part = other.perhaps_part;
    clutter = other.clutter;
    with_colours = other.with_colours;
    if (!with_colours) return;
    channels = other.channels;
    colour_range = other.colour_range;
    colours = other.colours;
    as_background = other.as_background;
}

void Evidence::rule_out_shadow(std::size_t pixel) {
    const float doubtful = perhaps[pixel] / perhaps_part;
    if (doubtful <= 0) return;
    Sums& sums = pixels[pixel];
    const float other = sums.other - (perhaps_counts ? perhaps[pixel] : 0) + doubtful;
    const float both = other + sums.plain;
    sums = {other / both, sums.plain / both};
    perhaps[pixel] = 0;
}

void Evidence::take_away(std::vector<int>& from, std::vector<Pixel>* before) {
    constexpr float least = 0.05f;  // of a shadow that is followed
    if (from.empty()) return;
    const auto keep = [&](int i) {
        const auto at = static_cast<std::size_t>(i);
        if (before) before->push_back({i, pixels[at], perhaps[at]});
    };
    for (const int i : from) {
        keep(i);
        pixels[static_cast<std::size_t>(i)] = {};
        perhaps[static_cast<std::size_t>(i)] = 0;
    }
    int first = width * height;
    int last = 0;
    while (!from.empty()) {
        const int i = from.back();
        from.pop_back();
        first = std::min(first, i);
        last = std::max(last, i);
        const int x = i % width;
        const auto visit = [&](int next) {
            float& shadow = perhaps[static_cast<std::size_t>(next)];
            if (shadow < least) return;
            keep(next);
            if (perhaps_counts) pixels[static_cast<std::size_t>(next)].other -= shadow;
            shadow = 0;
            from.push_back(next);
        };
        if (x > 0) visit(i - 1);
        if (x + 1 < width) visit(i + 1);
        if (i >= width) visit(i - width);
        if (i + width < width * height) visit(i + width);
    }
    sum_up({first / width, last / width + 1});
}

void Evidence::put_back(const std::vector<Pixel>& before) {
    if (before.empty()) return;
    int first = width * height;
    int last = 0;
    for (auto p = before.rbegin(); p != before.rend(); ++p) {
        pixels[static_cast<std::size_t>(p->index)] = p->sums;
        perhaps[static_cast<std::size_t>(p->index)] = p->perhaps;
        first = std::min(first, p->index);
        last = std::max(last, p->index);
    }
    sum_up({first / width, last / width + 1});
}

void Evidence::sum_up(const Rows& changed) {
    const auto line = static_cast<std::size_t>(width) + 1;
    const auto across = static_cast<std::size_t>(cells(width));
    const auto down = static_cast<std::size_t>(cells(height));
    row_sums.resize(line * static_cast<std::size_t>(height));
    cell_sums_.resize(across * down);
    box_sums.resize((across + 1) * (down + 1));
    // Several rows at once: within one each sum waits for the one before.
    constexpr int together = 4;
    int y = changed.begin;
    for (; y + together <= changed.end; y += together) {
        std::array<const Sums*, together> from;
        std::array<Sums*, together> row;
        std::array<Sums, together> sum{};
        for (std::size_t k = 0; k < together; ++k) {
            from[k] = pixels.data() + static_cast<std::ptrdiff_t>(y + static_cast<int>(k)) * width;
            row[k] = row_sums.data() + static_cast<std::size_t>(y + static_cast<int>(k)) * line;
            row[k][0] = {};
        }
        for (std::size_t x = 0; x + 1 < line; ++x) {
            for (std::size_t k = 0; k < together; ++k) {
                sum[k].other += from[k][x].other;
                sum[k].plain += from[k][x].plain;
                row[k][x + 1].other = sum[k].other;
                row[k][x + 1].plain = sum[k].plain;
            }
        }
    }
    for (; y < changed.end; ++y) {
        const Sums* from = pixels.data() + static_cast<std::ptrdiff_t>(y) * width;
        Sums* row = row_sums.data() + static_cast<std::size_t>(y) * line;
        row[0] = {};
        for (std::size_t x = 0; x + 1 < line; ++x) row[x + 1] = {row[x].other + from[x].other, row[x].plain + from[x].plain};
    }
    const auto first = static_cast<std::size_t>(changed.begin / cell);
    for (std::size_t cy = first; cy < static_cast<std::size_t>(cells(changed.end)); ++cy) {
        Sums* cell_row = cell_sums_.data() + cy * across;
        std::fill(cell_row, cell_row + across, Sums());
        const std::size_t bottom = std::min((cy + 1) * cell, static_cast<std::size_t>(height));
        for (std::size_t v = cy * cell; v < bottom; ++v) {
            const Sums* row = row_sums.data() + v * line;
            for (std::size_t cx = 0; cx < across; ++cx) {
                const Sums& begin = row[cx * cell];
                const Sums& end = row[std::min((cx + 1) * cell, line - 1)];
                cell_row[cx].other += end.other - begin.other;
                cell_row[cx].plain += end.plain - begin.plain;
            }
        }
    }
    for (std::size_t cy = first; cy < down; ++cy) {
        const Sums* from = cell_sums_.data() + cy * across;
        const Sums* above = box_sums.data() + cy * (across + 1);
        Sums* below = box_sums.data() + (cy + 1) * (across + 1);
        Sums row;
        below[0] = {};
        for (std::size_t cx = 0; cx < across; ++cx) {
            row = {row.other + from[cx].other, row.plain + from[cx].plain};
            below[cx + 1] = {above[cx + 1].other + row.other, above[cx + 1].plain + row.plain};
        }
    }
    const Sums all = box_sums.back();
    clutter = static_cast<double>(all.other) / std::max(1.0, static_cast<double>(all.other + all.plain));
}

}  // namespace roomfix
