// How a picture as a whole lies beside a reference of the same place, whatever stands there and in whatever light: direct alignment, block by block.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "roomfix/geometry/camera_model.hpp"
#include "roomfix/imaging/luma.hpp"

namespace roomfix {

struct AlignmentSettings {
    int width = 320;             // px, at most: pictures are shrunk to that first
    float dark = 6;              // grey levels added before the logarithm: read noise and black level of common cameras
    float level_noise = 1;       // grey levels, of a pixel of the small picture: compression and rounding
    float colour_noise = 0.01f;  // of its logarithm
    float blur = 0.15f;          // px of the small picture: what stays of an edge when it is shifted by parts of a pixel
    float least_slope = 0.03f;   // log per px, root mean square over a block: less says nothing of where it lies
    float alike = 4;             // times the variance expected, up to which a block shows the reference
    float same_noise = 8;        // neighbouring pixels whose errors are as good as one
    float most_nats = 4;         // that one block says for one motion against another: something may stand there
    double lost_below = 0.6;     // part of the blocks that shows the reference, below which other motions are looked for
    double most_turned = 0.1;    // rad, standard deviation of what somebody who bumps into a camera does to it
    double most_grown = 0.02;    // the same of its picture's size: a lens that is set anew
    int reach = 10;              // px of the smallest picture (an eighth of `width` wide or so), how far away
};

/// How the camera has moved: turned about its own axes (rad; x right, y down, z ahead), and its picture grown by this part around the principal point.
inline constexpr int motion_parameters = 4;
using PictureMotion = Eigen::Matrix<double, motion_parameters, 1>;

/// The pixel at which a camera that moved like that sees what was in the direction `ray` (z = 1) of its own frame before; nothing where it sees nothing.
std::optional<Eigen::Vector2d> seen_after(const CameraModel& model, const Eigen::Vector2d& ray, const PictureMotion& motion);

struct Alignment {
    PictureMotion motion = PictureMotion::Zero();
    double offset = 0;   // px of the full picture, root mean square over it: how far it lies off the reference
    double nats = 0;     // for this motion, against none
    double showing = 0;  // part of the blocks with structure that shows the reference at this motion: 0..1
};

class PictureAlignment {
public:
    explicit PictureAlignment(CameraModel model, const AlignmentSettings& settings = {}) : model_(std::move(model)), settings_(settings) {}

    const CameraModel& model() const { return model_; }
    bool has_reference() const { return !blocks_.empty(); }
    /// Of the camera's size. Where the reference has no structure at all, has_reference() stays false.
    void set_reference(LumaView reference);

    /// Of a picture of the reference's size. No allocation.
    const Alignment& align(LumaView picture);

private:
    using Jacobian = Eigen::Matrix<double, 2, motion_parameters>;
    /// A square of the small picture.
    struct Block {
        int x = 0, y = 0;                                  // its first pixel
        Eigen::Matrix2f slopes = Eigen::Matrix2f::Zero();  // sum of squares of the slopes, less their means
        float expected = 0;                                // variance of what is left between two pictures of it
        Eigen::Vector2d middle, ray;                       // px of the full picture; and its ray, z = 1
        Jacobian jacobian;                                 // px of the small picture that the middle moves, for small motions
        float still = 0;                                   // variance left without any motion; negative: not in the picture
        float left = 0;                                    // the same at the motion that was found
    };
    static constexpr int block_size = 16;   // px
    static constexpr int shrink_again = 4;  // from the small picture to the smallest

    /// A grey picture's logarithms.
    struct Logs {
        int width = 0, height = 0;
        std::vector<float> values;
        const float* at(int x, int y) const { return values.data() + static_cast<std::ptrdiff_t>(y) * width + x; }
    };
    void shrink(LumaView picture, Logs& logs);
    PictureMotion inverse_variances() const;
    std::optional<Eigen::Vector2d> shift_of(const Block& block, const PictureMotion& motion) const;
    static void shrink_more(const Logs& logs, Logs& smallest);
    float residual(const Block& block, const PictureMotion& motion, Eigen::Vector2f* by_shift) const;
    PictureMotion refined(PictureMotion motion);
    void weigh(const PictureMotion& motion, Alignment& found);
    PictureMotion searched() const;
    float score_at(int dx, int dy) const;
    double offset_of(const PictureMotion& motion) const;

    CameraModel model_;
    AlignmentSettings settings_;
    int factor_ = 1;  // pixels of the full picture per pixel of the small one
    Logs reference_, picture_;
    Logs smallest_reference_, smallest_;
    std::vector<float> slope_x_, slope_y_;  // of reference_
    std::vector<Block> blocks_;
    Alignment found_;
    std::array<float, 4096> log_of_{};  // of sixteenths of a grey level
    std::vector<int> sums_;
    std::vector<float> ratios_;
};

}  // namespace roomfix
