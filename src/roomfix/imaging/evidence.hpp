// How likely it is, pixel by pixel, that a frame shows something that is not the background in another light.
#pragma once

#include <cstddef>
#include <vector>

namespace roomfix {

/// Of one frame. A pixel speaks for something else, for the background, or, where it may as well be the background in another light, not at
/// all.
struct Evidence {
    /// Sums of probabilities over pixels.
    struct Sums {
        float other = 0;  // that they show something else
        float plain = 0;  // that they show the background in its own light
    };

    /// begin <= y < end.
    struct Rows {
        int begin = 0;
        int end = 0;
    };
    struct Pixel {
        int index = 0;
        Sums sums;
        float perhaps = 0;
    };
    static constexpr int cell = 4;  // px, edge of the squares that boxes are counted in

    int width = 0;
    int height = 0;
    int scale = 1;               // pixels of the frame per pixel here
    std::vector<Sums> pixels;    // row-major
    std::vector<float> perhaps;  // of each pixel: `perhaps_part` of the probability that it shows something else or as well a shadow, part of `other` ...
    bool perhaps_counts = true;  // ... false: that comes on top of it
    float perhaps_part = 1;
    std::vector<Sums> row_sums;  // (width + 1) per row: of all pixels to the left
    std::vector<Sums> box_sums;  // (cells across + 1) x (cells down + 1): of all cells above and to the left
    double clutter = 0;          // part of what the picture tells that is something else

    // Only where they are asked for: what learned looks of robots are compared with.
    bool with_colours = false;
    int channels = 0;                  // of `colours`
    double colour_range = 2;           // over which log colours of things of any colour are spread evenly, each channel
    std::vector<float> colours;        // log colours in the background's light, row-major, channels side by side
    std::vector<float> as_background;  // log of how much likelier each is of the background, in any light, than of a thing of any colour

    bool empty() const { return pixels.empty(); }
    /// Over the pixels begin <= x < end of a row.
    Sums run(int y, int begin, int end) const {
        const Sums* row = row_sums.data() + static_cast<std::ptrdiff_t>(y) * (width + 1);
        return {row[end].other - row[begin].other, row[end].plain - row[begin].plain};
    }
    /// Over all cells that left <= x < right, top <= y < bottom touches.
    Sums box(int left, int top, int right, int bottom) const {
        const auto at = [&](int x, int y) {
            return box_sums[static_cast<std::size_t>(y) * static_cast<std::size_t>(cells(width) + 1) + static_cast<std::size_t>(x)];
        };
        const int low_x = left / cell, low_y = top / cell, high_x = cells(right), high_y = cells(bottom);
        const Sums a = at(high_x, high_y), b = at(low_x, high_y), c = at(high_x, low_y), d = at(low_x, low_y);
        return {a.other - b.other - c.other + d.other, a.plain - b.plain - c.plain + d.plain};
    }
    /// Something stands on these pixels: they say nothing any more, and what may be a shadow and hangs together with them is its shadow. `from` is used
    /// up. `before`, if it is not null, gets what has changed.
    void take_away(std::vector<int>& from, std::vector<Pixel>* before = nullptr);
    /// Undoes it.
    void put_back(const std::vector<Pixel>& before);
    /// From now on what may as well be a shadow counts as something else, too. The sums have to be filled anew.
    void count_perhaps();
    /// A pixel that shows no shadow: it is something else or the background in its own light. The sums have to be filled anew.
    void rule_out_shadow(std::size_t pixel);
    /// Fills the sums from `pixels`, of which only some rows have changed.
    void sum_up(const Rows& changed);
    /// Takes over what another one says of its pixels, but not the sums.
    void copy_pixels(const Evidence& other);
    /// Fills all sums.
    void sum_up() { sum_up({0, height}); }

    static int cells(int length) { return (length + cell - 1) / cell; }

private:
    std::vector<Sums> cell_sums_;  // cells across x cells down
};

}  // namespace roomfix
