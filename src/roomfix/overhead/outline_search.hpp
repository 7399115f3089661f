// Poses whose outline runs along the foreground's border: for robots that are partly hidden, cut off or merged, where the
// foreground's area misleads.
#pragma once

#include <cstdint>
#include <vector>

#include "roomfix/overhead/robot_search.hpp"

namespace roomfix {

/// Distance of each pixel of a part of the image to the nearest border pixel of a mask, in thirds of a pixel (3-4 chamfer,
/// Borgefors 1986). Keeps its memory.
class BorderDistance {
public:
    /// Looks at the box, inclusive, grown by `margin` px. The image's own border is no border of the mask.
    void compute(const BitMask& mask, int left, int top, int right, int bottom, int margin);
    /// px; large outside the part that was computed.
    float at(const Eigen::Vector2d& pixel) const;

private:
    int left_ = 0, top_ = 0, width_ = 0, height_ = 0;
    std::vector<std::uint16_t> thirds_;
};

/// An outline with its part that lies on the border.
struct OutlineStart {
    Pose2 pose;
    double support = 0;  // 0..1 of all of the outline
};

/// The best poses around the places `around`, by the outline's support, best first, not twice the same. At most `most`.
void search_outline(const BorderDistance& border, const View& view, const ShapePoints& shape, const std::vector<CoarsePose>& around,
                    std::size_t most, std::vector<OutlineStart>& found);

}  // namespace roomfix
