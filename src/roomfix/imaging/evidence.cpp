#include "roomfix/imaging/evidence.hpp"

#include <algorithm>

namespace roomfix {

/// Takes a pixel into a region.
static void widen(Evidence::Region& region, int x, int y) {
    region.left = std::min(region.left, x);
    region.right = std::max(region.right, x + 1);
    region.top = std::min(region.top, y);
    region.bottom = std::max(region.bottom, y + 1);
}

void Evidence::weigh_shadow(std::size_t pixel, float part) {
    const std::uint16_t doubtful = perhaps[pixel];
    if (doubtful == 0) return;
    perhaps[pixel] = scaled(doubtful, part);
    pixels[pixel].other += perhaps[pixel] - (perhaps_counts ? counted(doubtful) : 0);
}

void Evidence::shadows_are_weighed() {
    perhaps_counts = true;
    perhaps_part = 1;
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
    const std::uint16_t doubtful = perhaps[pixel];
    if (doubtful == 0) return;
    Pixel& p = pixels[pixel];
    const int other = p.other - (perhaps_counts ? counted(doubtful) : 0) + doubtful;
    const int both = other + p.plain;
    p.other = static_cast<std::uint16_t>((certain * other + both / 2) / both);
    p.plain = static_cast<std::uint16_t>(certain - p.other);
    perhaps[pixel] = 0;
}

void Evidence::take_away(std::vector<int>& from, std::vector<Change>* before) {
    constexpr int least = certain / 20;  // of `certain`: what counts of a shadow that is followed
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
    Region changed{width, height, 0, 0};
    while (!from.empty()) {
        const int i = from.back();
        from.pop_back();
        const int x = i % width;
        widen(changed, x, i / width);
        const auto visit = [&](int next) {
            const auto at = static_cast<std::size_t>(next);
            const std::uint16_t counts = counted(perhaps[at]);
            if (counts < least) return;
            keep(next);
            if (perhaps_counts) pixels[at].other -= counts;
            perhaps[at] = 0;
            from.push_back(next);
        };
        if (x > 0) visit(i - 1);
        if (x + 1 < width) visit(i + 1);
        if (i >= width) visit(i - width);
        if (i + width < width * height) visit(i + width);
    }
    sum_up(changed);
}

void Evidence::put_back(const std::vector<Change>& before) {
    if (before.empty()) return;
    Region changed{width, height, 0, 0};
    for (auto p = before.rbegin(); p != before.rend(); ++p) {
        pixels[static_cast<std::size_t>(p->index)] = p->pixel;
        perhaps[static_cast<std::size_t>(p->index)] = p->perhaps;
        widen(changed, p->index % width, p->index / width);
    }
    sum_up(changed);
}

void Evidence::sum_up() {
    const auto line = static_cast<std::size_t>(width) + 1;
    const auto across = static_cast<std::size_t>(cells(width)) + 1;
    row_sums.resize(line * static_cast<std::size_t>(height));
    box_sums.resize(across * static_cast<std::size_t>(cells(height) + 1));
    for (std::size_t first = 0; first < row_sums.size(); first += line) row_sums[first] = 0;
    std::fill_n(box_sums.begin(), across, 0);
    sum_up({0, 0, width, height});
}

void Evidence::sum_up(const Region& changed) {
    const auto line = static_cast<std::size_t>(width) + 1;
    const auto across = static_cast<std::size_t>(cells(width));
    const auto down = static_cast<std::size_t>(cells(height));
    cell_sums_.resize(across);
    for (int y = changed.top; y < changed.bottom; ++y) {
        const Pixel* from = pixels.data() + static_cast<std::ptrdiff_t>(y) * width;
        std::uint64_t* row = row_sums.data() + static_cast<std::size_t>(y) * line;
        const auto right = static_cast<std::size_t>(changed.right);
        const std::uint64_t before = row[right];
        std::uint64_t sum = row[changed.left];
        for (auto x = static_cast<std::size_t>(changed.left); x < right; ++x) {
            sum += static_cast<std::uint64_t>(from[x].other) << 32 | from[x].plain;
            row[x + 1] = sum;
        }
        // Behind it all sums change by as much.
        for (std::size_t x = right + 1; x < line; ++x) row[x] += sum - before;
    }
    const auto begin = static_cast<std::size_t>(changed.top / cell);
    const auto end = static_cast<std::size_t>(cells(changed.bottom));
    const auto boxes_at = [&](std::size_t cy) { return box_sums.data() + cy * (across + 1); };
    last_boxes_.assign(boxes_at(end), boxes_at(end) + across + 1);
    for (std::size_t cy = begin; cy < end; ++cy) {
        std::fill(cell_sums_.begin(), cell_sums_.end(), 0);
        const std::size_t bottom = std::min((cy + 1) * cell, static_cast<std::size_t>(height));
        for (std::size_t v = cy * cell; v < bottom; ++v) {
            const std::uint64_t* row = row_sums.data() + v * line;
            for (std::size_t cx = 0; cx < across; ++cx) cell_sums_[cx] += row[std::min((cx + 1) * cell, line - 1)] - row[cx * cell];
        }
        const std::uint64_t* above = boxes_at(cy);
        std::uint64_t* below = boxes_at(cy + 1);
        std::uint64_t row = 0;
        below[0] = 0;
        for (std::size_t cx = 0; cx < across; ++cx) {
            row += cell_sums_[cx];
            below[cx + 1] = above[cx + 1] + row;
        }
    }
    // What has changed above goes into all boxes below.
    for (std::size_t cx = 0; cx <= across; ++cx) last_boxes_[cx] = boxes_at(end)[cx] - last_boxes_[cx];
    for (std::size_t cy = end; cy < down; ++cy) {
        std::uint64_t* below = boxes_at(cy + 1);
        for (std::size_t cx = 0; cx <= across; ++cx) below[cx] += last_boxes_[cx];
    }
    const Sums all = unpacked(box_sums.back());
    clutter = static_cast<double>(all.other) / std::max(1.0, static_cast<double>(all.other + all.plain));
}

}  // namespace roomfix
