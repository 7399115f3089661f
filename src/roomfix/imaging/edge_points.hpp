// Points on edges of light, subpixel, from a reduced picture: short on noise and quick.
#pragma once

#include <cstdint>
#include <vector>

#include "roomfix/imaging/luma.hpp"

namespace roomfix {

struct EdgePointSettings {
    int working_width = 320;         // px: pictures are reduced by whole factors to about this width
    double threshold = 3.2;          // times the gradients' noise
    double least_gradient = 0.35;    // grey levels per reduced px
    std::size_t most_points = 8000;  // the strongest
};

/// Where the gradient is largest along its own direction.
struct EdgePoint {
    float x = 0, y = 0;    // px of the full picture
    float nx = 0, ny = 0;  // direction towards the brighter side, unit length
    float strength = 0;    // gradient over its noise
};

/// Keeps its working memory; no allocation for pictures of the same size.
class EdgePointFinder {
public:
    explicit EdgePointFinder(const EdgePointSettings& settings = {}) : settings_(settings) {}

    /// All edge points of the picture. Pictures narrower or lower than three reduced pixels have none.
    void find(LumaView frame, std::vector<EdgePoint>& points);
    /// Factor by which the last picture was reduced.
    int reduction() const { return reduction_; }

private:
    void reduce(LumaView frame);
    void differentiate();
    std::int32_t threshold();

    EdgePointSettings settings_;
    int reduction_ = 1, width_ = 0, height_ = 0;
    double noise_ = 1;                 // standard deviation of gradients where nothing is, grey levels per reduced px
    std::vector<std::int16_t> small_;  // four times the grey level
    std::vector<std::int16_t> across_, down_, size_;
    std::vector<std::uint32_t> sums_;
};

}  // namespace roomfix
