// Where the foreground ends, and why: because the robot ends there, because something stands in front, or as a shadow.
#pragma once

#include <cstdint>
#include <vector>

#include "roomfix/imaging/background_model.hpp"
#include "roomfix/overhead/silhouette.hpp"

namespace roomfix {

/// The border pixels of the foreground in a part of the image. Keeps its memory.
class ForegroundBorder {
public:
    struct Pixel {
        Eigen::Vector2f place;            // px
        bool on_background_edge = false;  // the empty room has an edge there too: perhaps something stands in front
        bool of_shadow = false;           // what ends there may be a shadow
    };

    /// Looks at the box (px, inclusive). The image's own border is no border of the foreground.
    void compute(const BitMask& mask, const BitMask& shadow, LumaView background, int left, int top, int right, int bottom);
    const std::vector<Pixel>& pixels() const { return pixels_; }

    /// The part of the border that a robot with this outline does not explain: 0 to 1. What lies on its outline is explained, a
    /// shadow's border outside of it, and what lies on an edge of the empty room.
    double unexplained(const Silhouette& silhouette) const;

private:
    std::vector<Pixel> pixels_;
};

/// Distance of each pixel of a part of the image to the nearest border pixel that is not on an edge of the empty room, in
/// thirds of a pixel (3-4 chamfer, Borgefors 1986). Keeps its memory.
class BorderDistance {
public:
    /// Looks at the box, inclusive, grown by `margin` px, in an image of the given size.
    void compute(const ForegroundBorder& border, int width, int height, int left, int top, int right, int bottom, int margin);
    /// px; large outside the part that was computed.
    float at(const Eigen::Vector2d& pixel) const;

private:
    int left_ = 0, top_ = 0, width_ = 0, height_ = 0;
    std::vector<std::uint16_t> thirds_;
};

}  // namespace roomfix
