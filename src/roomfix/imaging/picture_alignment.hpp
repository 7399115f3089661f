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
    float same_noise = 8;        // neighbouring pixels whose errors are as good as one
    float share_other = 0.5f;    // of blocks may show something else
    float most_nats = 4;         // that one block says for one motion against another
    double found_above = 0.9;    // part of the blocks that shows the reference, above which no other motion is looked for
    double most_turned = 0.1;    // rad, standard deviation of what somebody who bumps into a camera does to it
    double most_grown = 0.02;    // the same of its picture's size: a lens that is set anew
    int reach = 10;              // px of the smallest picture, a quarter of the small one: how far away it is looked for
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
    static constexpr int levels = 3;       // of a pyramid: the small picture, then each half as wide as the one before
    static constexpr int block_size = 16;  // px of the small picture

    /// A grey picture's logarithms.
    struct Logs {
        int width = 0, height = 0;
        std::vector<float> values;

        void resize(int new_width, int new_height);
        const float* at(int x, int y) const { return values.data() + static_cast<std::ptrdiff_t>(y) * width + x; }
    };
    struct Level {
        Logs reference, picture;
        std::vector<float> slope_x, slope_y;  // of the reference, per px
    };
    /// A square of the reference with structure.
    struct Block {
        int x = 0, y = 0;                            // its first pixel in the small picture
        Eigen::Vector2d middle, ray;                 // px of the full picture; and its ray, z = 1
        Jacobian jacobian;                           // px of the full picture that the middle moves, for small motions
        std::array<Eigen::Matrix2f, levels> slopes;  // sums of their squares, less their means
        float expected = 0;                          // variance of what is left between two pictures of it
        float other = 0;                             // the same if the second one shows something else
        float still = 0;                             // variance left without any motion; negative: not in the picture
        float left = 0;                              // the same at the motion that was found
    };
    /// What is left between a block of the reference and the picture, but for one brightness.
    struct Residual {
        float variance = -1;       // negative: the block is not in the picture
        Eigen::Vector2f gradient;  // sum of what is left times the slopes
    };

    void shrink(LumaView picture, Logs& logs);
    static void halve(const Logs& logs, Logs& half);
    void fill_pyramid(LumaView picture, Logs Level::*which);
    void add_block(int x, int y);
    PictureMotion inverse_variances() const;
    Residual residual(int level, const Block& block, const PictureMotion& motion) const;
    PictureMotion refined(PictureMotion motion, int coarsest) const;
    void weigh(const PictureMotion& motion, Alignment& found);
    float block_nats(float left, float expected, float other) const;
    PictureMotion searched() const;
    float score_at(int dx, int dy) const;
    double offset_of(const PictureMotion& motion) const;

    CameraModel model_;
    AlignmentSettings settings_;
    int factor_ = 1;  // pixels of the full picture per pixel of the small one
    std::array<Level, levels> levels_;
    std::vector<Block> blocks_;
    Alignment found_;
    std::array<float, 4096> log_of_{};  // of sixteenths of a grey level
    std::vector<int> sums_;
    std::vector<float> ratios_;
};

}  // namespace roomfix
