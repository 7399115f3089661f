// A tag's corners to a few hundredths of a pixel: its whole pattern is laid onto the picture.
#pragma once

#include <optional>

#include "roomfix/geometry/camera_model.hpp"
#include "roomfix/imaging/tag_detector.hpp"

namespace roomfix {

struct TagRefinerSettings {
    double capture = 2.5;  // px: half the width of what is looked at along borders
    int plain_step = 16;   // of the other pixels every so manieth
    int most_rounds = 25;
    double start_blur = 0.8;        // px, standard deviation
    double least_blur = 0.3;        // px
    double widest_blur = 4;         // px
    double most_moved = 1.5;        // px: a corner that moves farther is another one ...
    double most_moved_part = 0.02;  // ... and this part of the tag's edge besides: white may bleed
    double alike_residuals = 6;     // neighbouring pixels err alike: so many count as one
    double floor_sigma = 0.015;     // px: what the model leaves out of each corner
    double least_contrast = 20;     // grey levels between black and white
    double largest_misfit = 0.15;   // rms of the residuals, as a part of the contrast
};

/// A tag that the detector saw, with better corners and their covariance. Homography, blur, how far white bleeds into black, and light that falls off evenly
/// across the tag are fitted to all its pixels (Levenberg-Marquardt on grey levels); the lens is bent back before. Nothing where the pattern does not fit: too
/// small, half hidden, in a hard shadow.
std::optional<SeenTag> refine_tag(LumaView frame, const CameraModel& model, const SeenTag& seen, const TagPicture& picture,
                                  const TagRefinerSettings& settings = {});

}  // namespace roomfix
