// Where light changes across a short stretch of a predicted line: subpixel, with the noise that the picture itself shows.
#pragma once

#include <Eigen/Core>
#include <array>

#include "roomfix/base/fixed_list.hpp"
#include "roomfix/imaging/luma.hpp"

namespace roomfix {

/// A stretch of a line in the picture, px.
struct LineStretch {
    Eigen::Vector2d from = Eigen::Vector2d::Zero();
    Eigen::Vector2d to = Eigen::Vector2d::Zero();
    Eigen::Vector2d normal() const {
        const Eigen::Vector2d along = (to - from).normalized();
        return {-along.y(), along.x()};
    }
};

/// Grey levels to linear light on the same scale: lenses blur light, not grey levels.
class LightTable {
public:
    explicit LightTable(double gamma = 2.2);
    /// 0 <= grey <= 255
    float operator[](float grey) const {
        const int below = static_cast<int>(grey);
        return table_[static_cast<std::size_t>(below)] +
               (grey - static_cast<float>(below)) * (table_[static_cast<std::size_t>(below) + 1] - table_[static_cast<std::size_t>(below)]);
    }

private:
    std::array<float, 257> table_;
};

/// Mean light at one distance from a stretch.
struct LightAt {
    float distance = 0;  // px, along the stretch's normal
    float light = 0;
    float count = 0;  // pixels
};

/// The light around a stretch by distance, nearest half pixels together.
struct LightProfile {
    static constexpr double bin = 0.5;      // px
    static constexpr double widest = 15.5;  // px
    static constexpr int most = 64;
    FixedList<LightAt, most> values;
};

/// Reads all pixels within `reach` px (at most LightProfile::widest) of the stretch; only every `skip`-th row, or column if the line lies.
/// False where the stretch leaves the picture.
bool read_profile(LumaView frame, const LightTable& light, const LineStretch& stretch, double reach, int skip, LightProfile& profile);

/// A blurred step of light across the stretch, or a crease: a line, mostly a dark one, where two walls meet that are equally light.
struct EdgeStep {
    double offset = 0;          // px from the stretch along its normal
    double variance = 1;        // px^2, of the offset; from what the model leaves of the light
    double contrast = 0;        // light on the normal's side less light on the other, or in a crease less light beside it; 0..255 in linear light
    double contrast_sigma = 1;  // of the contrast
    double blur = 0;            // px, standard deviation of the blurred edge, as this stretch sees it
    double blur_variance = 1;   // px^2
    double noise = 0;           // of the light: variance of one pixel about the model
};

/// How an edge shows.
enum class EdgeKind { step, crease };

/// What of the light around a step is fitted: the fewer unknowns, the less exact, and the less easily led astray.
enum class StepModel {
    full,    // a step of unknown blur between two slopes (corners are darker than what is around them)
    sloped,  // a step of known blur between two slopes
    plain,   // a step of known blur on one slope
    coarse,  // a step of known blur
    crease,  // a crease of known width, and a step, on one slope
};

/// Fits a blurred step c Phi((d - offset) / blur), or a crease c exp(-((d - offset) / blur)^2 / 2), to the profile within `reach`; to first order in the
/// offset and the blur, so read again at the place it tells. A crease's blur is its width, and is not fitted. False where too few distances were read.
bool fit_step(const LightProfile& profile, double blur, double reach, StepModel model, EdgeStep& step);

}  // namespace roomfix
