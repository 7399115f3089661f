// Connected components of a packed mask, by runs.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "roomfix/imaging/bit_mask.hpp"

namespace roomfix {

/// One 8-connected component.
struct Component {
    std::int64_t area = 0;  // px
    int left = 0;           // bounding box, inclusive
    int top = 0;
    int right = 0;
    int bottom = 0;
    Eigen::Vector2d centroid = Eigen::Vector2d::Zero();    // px
    Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  // second central moments / area, px^2
};

/// Finds components; keeps its memory between frames.
class ComponentFinder {
public:
    /// The components with at least `min_area` pixels, largest first; equal areas from top to bottom. The result is valid
    /// until the next call. Needs every set bit to lie in its row's span, as BitMask keeps it.
    const std::vector<Component>& find(const BitMask& mask, std::int64_t min_area);
    /// What the last call found.
    const std::vector<Component>& found() const { return components_; }

private:
    struct Run {
        int begin, end;  // begin <= x < end
        int label;
    };
    struct Sums {
        std::int64_t area, x, y, xx, xy, yy;
        int left, top, right, bottom;
    };
    int root(int label);
    int join(int a, int b);
    void read_runs(const BitMask& mask, int y);
    void add_run(const Run& run, int y);

    std::vector<Run> above_;
    std::vector<Run> current_;
    std::vector<int> parents_;
    std::vector<Sums> sums_;
    std::vector<Component> components_;
};

}  // namespace roomfix
