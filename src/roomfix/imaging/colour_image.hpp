// Small colour pictures of frames, in which pixels are told from the background by their colour.
#pragma once

#include <cstdint>
#include <vector>

#include "roomfix/imaging/luma.hpp"

namespace roomfix {

/// A frame's colours, each pixel the mean of `scale` x `scale` pixels of the frame. One channel where the camera gives grey only.
/// Pixel (x, y) of it has its centre at (x + 0.5) * scale - 0.5 of the frame, and so for y.
struct ColourImage {
    int width = 0;
    int height = 0;
    int channels = 3;  // blue, green, red; or 1: grey
    int scale = 1;
    std::vector<std::uint8_t> values;  // row-major, channels side by side

    bool empty() const { return values.empty(); }
    std::size_t pixels() const { return static_cast<std::size_t>(width) * static_cast<std::size_t>(height); }
};

/// A frame as grey levels and, where there are any, small in colour.
struct PictureView {
    LumaView grey;
    const ColourImage* colour = nullptr;

    PictureView() = default;
    PictureView(LumaView grey_frame, const ColourImage* colours = nullptr) : grey(grey_frame), colour(colours && !colours->empty() ? colours : nullptr) {}
    PictureView(const LumaImage& grey_frame, const ColourImage* colours = nullptr) : PictureView(grey_frame.view(), colours) {}
};

/// How much smaller the colour picture of a frame of that width is: at most 640 pixels wide.
int colour_scale(int frame_width);

/// Shrinks a frame. `bgr`: interleaved, rows `stride` bytes apart. A picture without any colour becomes a grey one. No allocation when the
/// size stays.
void shrink_colour(const std::uint8_t* bgr, int width, int height, std::ptrdiff_t stride, ColourImage& image);
/// The same from a grey frame.
void shrink_grey(LumaView frame, ColourImage& image);

/// A colour picture as grey, for comparing with a background that was learned in grey.
void make_grey(ColourImage& image);

}  // namespace roomfix
