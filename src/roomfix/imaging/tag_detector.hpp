// AprilTags of the family tag36h11 in a picture, by libapriltag.
#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <vector>

#include "roomfix/imaging/luma.hpp"

namespace roomfix {

struct TagDetectorSettings {
    float decimation = 1;        // 2: search in a picture half as large, four times as fast, for tags of more than some 30 px
    int most_corrected = 1;      // bits of a tag's code that may be wrong
    double least_margin = 30;    // grey levels between black and white bits
    double corner_sigma = 0.08;  // px, of each corner's coordinates
};

struct SeenTag {
    int number = 0;
    std::array<Eigen::Vector2d, 4> corners;  // px, of the black square as it is read: bottom left, bottom right, top right, top left
};

class TagDetector {
public:
    explicit TagDetector(const TagDetectorSettings& settings = {});
    ~TagDetector();
    TagDetector(TagDetector&&) noexcept;
    TagDetector& operator=(TagDetector&&) noexcept;

    /// The tags of a frame. `tags` is cleared first.
    void detect(LumaView frame, std::vector<SeenTag>& tags);
    const TagDetectorSettings& settings() const { return settings_; }

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
    TagDetectorSettings settings_;
};

/// A tag's picture, one pixel per bit with its white border: 10 x 10 pixels, 0 or 255; the black square is the inner 8 x 8.
LumaImage tag_picture(int number);

}  // namespace roomfix
