// Pictures as cameras and video decoders give them, brightness apart from colour (YUV), as luma and small in colour.
#pragma once

#include <cstddef>
#include <cstdint>

#include "roomfix/imaging/colour_image.hpp"
#include "roomfix/imaging/luma.hpp"

namespace roomfix {

/// A picture that somebody else owns. Pixel (x, y) has its brightness at `y[row * y_stride + column * y_step]` and its colour at
/// `u[(row >> shift_y) * colour_stride + (column >> shift_x) * colour_step]`, and so in `v`. Without `u` and `v` it is grey.
struct YuvView {
    const std::uint8_t* y = nullptr;
    const std::uint8_t* u = nullptr;
    const std::uint8_t* v = nullptr;
    int width = 0, height = 0;
    std::ptrdiff_t y_stride = 0, colour_stride = 0;  // bytes from row to row
    int y_step = 1, colour_step = 1;                 // bytes from value to value
    int shift_x = 1, shift_y = 1;                    // colour has half as many columns, rows
    bool full_range = false;                         // black and white are 0 and 255, else 16 and 235
};

/// `bytes` as two pixels in four bytes: Y U Y V.
YuvView yuyv_view(const std::uint8_t* bytes, int width, int height, std::ptrdiff_t stride);

/// The brightness, 0 to 255. No allocation when the size stays.
void luma_from_yuv(const YuvView& picture, LumaImage& image);
/// The colours (ITU-R BT.601), small; grey where the picture is.
void colour_from_yuv(const YuvView& picture, ColourImage& colour);

}  // namespace roomfix
