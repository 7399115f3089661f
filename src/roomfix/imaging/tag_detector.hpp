// Printed square tags in a picture: AprilTag's families and ArUco's dictionaries, all by libapriltag.
#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <vector>

#include "roomfix/base/tag_family.hpp"
#include "roomfix/imaging/luma.hpp"

namespace roomfix {

struct TagDetectorSettings {
    float decimation = 1;          // 2: search in a picture half as large, four times as fast, for tags of more than some 30 px
    int most_corrected = 1;        // bits of a tag's code that may be wrong ...
    double largest_chance = 1e-4;  // ... but fewer where any square would be read as one of the family's tags with more than this chance
    double least_margin = 30;      // grey levels between black and white bits
    double corner_sigma = 0.08;    // px, of each corner's coordinates
};

struct SeenTag {
    TagFamily family = TagFamily::tag36h11;
    int number = 0;
    std::array<Eigen::Vector2d, 4> corners;  // px, where black and white meet, as it is read: bottom left, bottom right, top right, top left
    Eigen::Matrix<double, 8, 8> covariance = 0.08 * 0.08 * Eigen::Matrix<double, 8, 8>::Identity();  // px^2, of u, v of each corner
};

class TagDetector {
public:
    /// `families`: those that are looked for; others take time and give false alarms. A family that this build cannot read is left out.
    explicit TagDetector(const std::vector<TagFamily>& families = {TagFamily::tag36h11}, const TagDetectorSettings& settings = {});
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

/// ArUco's dictionaries come from OpenCV's aruco module, which a build may lack.
bool can_read(TagFamily family);

/// A tag as it is printed.
struct TagPicture {
    LumaImage bits;  // one pixel per bit, with the white border that it needs: 0 or 255
    int square = 0;  // px: edge of the square in the middle whose corners are read
};
/// Of a family that this build can read.
TagPicture tag_picture(TagFamily family, int number);

}  // namespace roomfix
