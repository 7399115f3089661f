// Grey-level images: 8 bit, row-major, centre of the top-left pixel at (0, 0).
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <cstring>
#include <vector>

namespace roomfix {

/// A grey image that somebody else owns.
struct LumaView {
    const std::uint8_t* data = nullptr;
    int width = 0;
    int height = 0;
    std::ptrdiff_t stride = 0;  // bytes from row to row

    const std::uint8_t* row(int y) const { return data + y * stride; }
    std::uint8_t at(int x, int y) const { return row(y)[x]; }
};

/// A grey image with its memory. Rows start on multiples of 64 bytes from each other; reusing an image of the same size
/// does not allocate.
class LumaImage {
public:
    LumaImage() = default;
    LumaImage(int width, int height) { resize(width, height); }

    void resize(int width, int height) {
        width_ = width;
        height_ = height;
        stride_ = (width + 63) / 64 * 64;
        pixels_.resize(static_cast<std::size_t>(stride_) * static_cast<std::size_t>(height) + 64);
    }
    int width() const { return width_; }
    int height() const { return height_; }
    bool empty() const { return width_ == 0 || height_ == 0; }
    std::uint8_t* row(int y) { return pixels_.data() + y * stride_; }
    const std::uint8_t* row(int y) const { return pixels_.data() + y * stride_; }
    LumaView view() const { return {pixels_.data(), width_, height_, stride_}; }
    operator LumaView() const { return view(); }

private:
    int width_ = 0;
    int height_ = 0;
    std::ptrdiff_t stride_ = 0;
    std::vector<std::uint8_t> pixels_;
};

inline LumaImage copy_of(LumaView view) {
    LumaImage image(view.width, view.height);
    for (int y = 0; y < view.height; ++y) std::memcpy(image.row(y), view.row(y), static_cast<std::size_t>(view.width));
    return image;
}

/// The grey level between pixels, bilinear. The position must lie at least one pixel inside the image.
inline float sample(const LumaView& image, float x, float y) {
    const int column = static_cast<int>(x);
    const int line = static_cast<int>(y);
    const float fx = x - static_cast<float>(column);
    const float fy = y - static_cast<float>(line);
    const std::uint8_t* p = image.data + line * image.stride + column;
    const std::uint8_t* q = p + image.stride;
    const float top = static_cast<float>(p[0]) + fx * static_cast<float>(p[1] - p[0]);
    const float bottom = static_cast<float>(q[0]) + fx * static_cast<float>(q[1] - q[0]);
    return top + fy * (bottom - top);
}

}  // namespace roomfix
