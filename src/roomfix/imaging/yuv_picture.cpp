#include "roomfix/imaging/yuv_picture.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace roomfix {
namespace {

constexpr double video_black = 16, video_white = 235, video_colour = 224;

std::uint8_t to_byte(double value) { return static_cast<std::uint8_t>(std::clamp(std::lround(value), 0L, 255L)); }

/// Brightness of video as brightness from 0 to 255.
std::array<std::uint8_t, 256> stretched() {
    std::array<std::uint8_t, 256> table{};
    for (std::size_t i = 0; i < table.size(); ++i) table[i] = to_byte((static_cast<double>(i) - video_black) * 255 / (video_white - video_black));
    return table;
}

/// Sum of the values of columns [x0, x1) and rows [y0, y1).
int sum_of(const std::uint8_t* plane, std::ptrdiff_t stride, int step, int x0, int x1, int y0, int y1) {
    int sum = 0;
    for (int y = y0; y < y1; ++y) {
        const std::uint8_t* row = plane + y * stride;
        for (int x = x0; x < x1; ++x) sum += row[x * step];
    }
    return sum;
}

}  // namespace

YuvView yuyv_view(const std::uint8_t* bytes, int width, int height, std::ptrdiff_t stride) {
    YuvView view;
    view.y = bytes;
    view.u = bytes + 1;
    view.v = bytes + 3;
    view.width = width;
    view.height = height;
    view.y_stride = view.colour_stride = stride;
    view.y_step = 2;
    view.colour_step = 4;
    view.shift_y = 0;
    return view;
}

void luma_from_yuv(const YuvView& picture, LumaImage& image) {
    static const std::array<std::uint8_t, 256> stretch = stretched();
    image.resize(picture.width, picture.height);
    for (int y = 0; y < picture.height; ++y) {
        const std::uint8_t* from = picture.y + y * picture.y_stride;
        std::uint8_t* to = image.row(y);
        if (picture.full_range && picture.y_step == 1) {
            std::copy_n(from, picture.width, to);
        } else if (picture.full_range) {
            for (int x = 0; x < picture.width; ++x) to[x] = from[x * picture.y_step];
        } else {
            for (int x = 0; x < picture.width; ++x) to[x] = stretch[from[x * picture.y_step]];
        }
    }
}

void colour_from_yuv(const YuvView& picture, ColourImage& colour) {
    const int scale = colour_scale(picture.width);
    colour.scale = scale;
    colour.width = std::max(picture.width / scale, 1);
    colour.height = std::max(picture.height / scale, 1);
    colour.channels = picture.u == nullptr ? 1 : 3;
    colour.values.resize(colour.pixels() * static_cast<std::size_t>(colour.channels));
    const double gain = picture.full_range ? 1 : 255 / (video_white - video_black);
    const double colour_gain = picture.full_range ? 1 : 255 / video_colour;
    const double black = picture.full_range ? 0 : video_black;
    bool grey = true;
    std::uint8_t* to = colour.values.data();
    for (int row = 0; row < colour.height; ++row) {
        const int y0 = row * scale, y1 = std::min(y0 + scale, picture.height);
        const int cy0 = y0 >> picture.shift_y, cy1 = ((y1 - 1) >> picture.shift_y) + 1;
        for (int column = 0; column < colour.width; ++column) {
            const int x0 = column * scale, x1 = std::min(x0 + scale, picture.width);
            const double y = gain * (sum_of(picture.y, picture.y_stride, picture.y_step, x0, x1, y0, y1) / static_cast<double>((x1 - x0) * (y1 - y0)) - black);
            if (colour.channels == 1) {
                *to++ = to_byte(y);
                continue;
            }
            const int cx0 = x0 >> picture.shift_x, cx1 = ((x1 - 1) >> picture.shift_x) + 1;
            const double count = (cx1 - cx0) * (cy1 - cy0);
            const double u = colour_gain * (sum_of(picture.u, picture.colour_stride, picture.colour_step, cx0, cx1, cy0, cy1) / count - 128);
            const double v = colour_gain * (sum_of(picture.v, picture.colour_stride, picture.colour_step, cx0, cx1, cy0, cy1) / count - 128);
            to[0] = to_byte(y + 1.772 * u);
            to[1] = to_byte(y - 0.344136 * u - 0.714136 * v);
            to[2] = to_byte(y + 1.402 * v);
            grey = grey && to[0] == to[1] && to[1] == to[2];
            to += 3;
        }
    }
    if (grey) make_grey(colour);
}

}  // namespace roomfix
