#include "roomfix/imaging/colour_image.hpp"

#include <algorithm>
#include <cstdlib>

namespace roomfix {
namespace {

constexpr int widest = 640;

/// Means over scale x scale pixels; what is left over at the right and at the bottom is not used.
void shrink(const std::uint8_t* data, int width, int height, std::ptrdiff_t stride, int channels, ColourImage& image) {
    const int scale = colour_scale(width);
    image.scale = scale;
    image.width = std::max(width / scale, 1);
    image.height = std::max(height / scale, 1);
    image.channels = channels;
    image.values.resize(image.pixels() * static_cast<std::size_t>(channels));
    const int area = scale * scale;
    std::uint8_t* to = image.values.data();
    if (scale == 1) {
        const auto line = static_cast<std::size_t>(width) * static_cast<std::size_t>(channels);
        for (int y = 0; y < height; ++y, to += line) std::copy_n(data + y * stride, line, to);
        return;
    }
    for (int y = 0; y < image.height; ++y) {
        for (int x = 0; x < image.width; ++x) {
            for (int c = 0; c < channels; ++c) {
                int sum = 0;
                for (int v = 0; v < scale; ++v) {
                    const std::uint8_t* from = data + (y * scale + v) * stride + static_cast<std::ptrdiff_t>(x) * scale * channels + c;
                    for (int u = 0; u < scale; ++u) sum += from[u * channels];
                }
                *to++ = static_cast<std::uint8_t>((sum + area / 2) / area);
            }
        }
    }
}

}  // namespace

int colour_scale(int frame_width) { return std::max(1, (frame_width + widest - 1) / widest); }

void shrink_colour(const std::uint8_t* bgr, int width, int height, std::ptrdiff_t stride, ColourImage& image) {
    shrink(bgr, width, height, stride, 3, image);
    for (std::size_t i = 0; i < image.values.size(); i += 3) {
        if (image.values[i] != image.values[i + 1] || image.values[i] != image.values[i + 2]) return;
    }
    make_grey(image);
}

void shrink_grey(LumaView frame, ColourImage& image) { shrink(frame.data, frame.width, frame.height, frame.stride, 1, image); }

void make_grey(ColourImage& image) {
    if (image.channels == 1) return;
    const std::size_t pixels = image.pixels();
    for (std::size_t i = 0; i < pixels; ++i) {
        const std::uint8_t* p = image.values.data() + 3 * i;
        image.values[i] = static_cast<std::uint8_t>((29 * p[0] + 150 * p[1] + 77 * p[2] + 128) >> 8);
    }
    image.channels = 1;
    image.values.resize(pixels);
}

}  // namespace roomfix
