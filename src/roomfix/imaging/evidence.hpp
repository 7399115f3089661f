// How likely it is, pixel by pixel, that a frame shows something that is not the background in another light.
#pragma once

#include <cstddef>
#include <cstdint>
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

    /// Probabilities in parts of `certain`: sums of whole numbers are exact.
    struct Pixel {
        std::uint16_t other = 0;
        std::uint16_t plain = 0;

        bool operator==(const Pixel&) const = default;
    };
    static constexpr int certain = 2000;

    /// left <= x < right, top <= y < bottom.
    struct Region {
        int left = 0, top = 0, right = 0, bottom = 0;
    };
    /// A pixel as it was.
    struct Change {
        int index = 0;
        Pixel pixel;
        std::uint16_t perhaps = 0;
    };
    static constexpr int cell = 4;  // px, edge of the squares that boxes are counted in

    int width = 0;
    int height = 0;
    int scale = 1;                       // pixels of the frame per pixel here
    std::vector<Pixel> pixels;           // row-major
    std::vector<std::uint16_t> perhaps;  // of each pixel, in parts of `certain`: it may as well be a shadow as something else. `perhaps_part` of it is ...
    bool perhaps_counts = true;          // ... part of `other`; false: not yet
    float perhaps_part = 1;
    std::vector<std::int8_t> light;       // of each pixel that is not plainly the background: hundredths of the log of its light over the background's
    std::vector<std::uint64_t> row_sums;  // (width + 1) per row: of all pixels to the left; `other` in the upper half, `plain` in the lower
    std::vector<std::uint64_t> box_sums;  // (cells across + 1) x (cells down + 1): of all cells above and to the left, in the same way
    double clutter = 0;                   // part of what the picture tells that is something else

    // Only where they are asked for: what learned looks of robots are compared with.
    bool with_colours = false;
    int channels = 0;                  // of `colours`
    double colour_range = 2;           // over which log colours of things of any colour are spread evenly, each channel
    std::vector<float> colours;        // log colours in the background's light, row-major, channels side by side
    std::vector<float> as_background;  // log of how much likelier each is of the background, in any light, than of a thing of any colour

    bool empty() const { return pixels.empty(); }
    /// Of one pixel.
    Sums at(std::size_t pixel) const { return {part_of(pixels[pixel].other), part_of(pixels[pixel].plain)}; }
    /// Over the pixels begin <= x < end of a row.
    Sums run(int y, int begin, int end) const { return unpacked(packed_run(y, begin, end)); }
    /// The same in parts of `certain`, `other` in the upper half.
    std::uint64_t packed_run(int y, int begin, int end) const {
        const std::uint64_t* row = row_sums.data() + static_cast<std::ptrdiff_t>(y) * (width + 1);
        return row[end] - row[begin];
    }
    /// Over all cells that left <= x < right, top <= y < bottom touches.
    Sums box(int left, int top, int right, int bottom) const {
        const auto sums_at = [&](int x, int y) {
            return box_sums[static_cast<std::size_t>(y) * static_cast<std::size_t>(cells(width) + 1) + static_cast<std::size_t>(x)];
        };
        const int low_x = left / cell, low_y = top / cell, high_x = cells(right), high_y = cells(bottom);
        return unpacked(sums_at(high_x, high_y) - sums_at(low_x, high_y) - sums_at(high_x, low_y) + sums_at(low_x, low_y));
    }
    /// Something stands on these pixels: they say nothing any more, and what may be a shadow and hangs together with them is its shadow. `from` is used
    /// up. `before`, if it is not null, gets what has changed.
    void take_away(std::vector<int>& from, std::vector<Change>* before = nullptr);
    /// Undoes it.
    void put_back(const std::vector<Change>& before);
    /// Of a pixel that may as well be a shadow: `part` of that counts as something else, and is all that is left in `perhaps`. Once all pixels were asked
    /// about, shadows_are_weighed() says so. The sums have to be filled anew.
    void weigh_shadow(std::size_t pixel, float part);
    void shadows_are_weighed();
    /// A pixel that shows no shadow: it is something else or the background in its own light. The sums have to be filled anew.
    void rule_out_shadow(std::size_t pixel);
    /// Fills the sums from `pixels`, of which only a region has changed.
    void sum_up(const Region& changed);
    /// Takes over what another one says of its pixels, but not the sums.
    void copy_pixels(const Evidence& other);
    /// Fills all sums.
    void sum_up();

    /// Sums in parts of `certain`, `other` in the upper half.
    static Sums unpacked(std::uint64_t sums) { return {part_of(sums >> 32), part_of(sums & 0xffffffff)}; }
    static int cells(int length) { return (length + cell - 1) / cell; }
    /// What of a pixel's `perhaps` is part of `other`, once it counts.
    std::uint16_t counted(std::uint16_t doubtful) const { return scaled(doubtful, perhaps_part); }
    static std::uint16_t scaled(std::uint16_t parts, float by) { return static_cast<std::uint16_t>(by * static_cast<float>(parts) + 0.5f); }
    /// A probability in parts of `certain`.
    static std::uint16_t parts(float probability) { return static_cast<std::uint16_t>(probability * certain + 0.5f); }

private:
    static float part_of(std::uint64_t parts) { return static_cast<float>(parts) / certain; }
    // Working memory.
    std::vector<std::uint64_t> cell_sums_;   // of a row of cells
    std::vector<std::uint64_t> last_boxes_;  // above the first row of cells that has not changed
};

}  // namespace roomfix
