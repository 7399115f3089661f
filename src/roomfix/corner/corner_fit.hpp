// A corner's three edges fitted to the picture: all five unknowns at once, straight through the lens model.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "roomfix/base/decompositions.hpp"
#include "roomfix/corner/corner_geometry.hpp"
#include "roomfix/corner/edge_contrast.hpp"
#include "roomfix/corner/edge_step.hpp"
#include "roomfix/geometry/camera_model.hpp"
#include "roomfix/imaging/luma.hpp"

namespace roomfix {

struct CornerFitSettings {
    double stretch = 16;                    // px: length of the pieces in which an edge is read ...
    double longest = 64;                    // ... and, px at 640 px of width, of a faint edge
    double plain = 8;                       // standard deviations of contrast that make a piece long enough
    double first_gap = 2;                   // px left out at the corner, where all three edges meet
    double border = 3;                      // px left out at the picture's border
    double least_part = 0.25;               // of a piece's length, for the last one, which the border cuts off
    double blur = 1.1;                      // px, of the edges, before the picture tells
    double least_blur = 0.6;                // px
    double widest_blur = 2.5;               // px
    double widest_capture = 8;              // px
    double near = 4;                        // px: from here one round of each width is enough
    double wide = 10;                       // blurs: how far from an edge the light is read ...
    double narrow = 5;                      // ... if something lies closer
    double tight = 2.6;                     // ... and if it lies closer still
    double noisier = 2.5;                   // times more noise in the wide reading tells that something does
    double least_contrast = 4;              // standard deviations: a weaker step is none
    double shared = 96;                     // px at 640 px of width: pieces of a faint edge share one contrast with those this far to both sides
    double least_contrast_variance = 0.02;  // of a piece, of light squared
    double largest_offset = 1.2;            // blurs: a step farther off belongs to something else
    double model_sigma = 0.017;             // px: real edges are not quite straight
    double soft_blur = 1.6;                 // px, of finish_softly()
    double crease = 1.6;                    // px: half the width of a crease, as the lens draws it
    double crease_reach = 5;                // of that: how far from a crease the light is read
    double crease_sigma = 0.25;             // px: a crease lies this far beside where the walls meet, all of it to the same side
    double merged = 1.8;                    // times the sharpest edge's blur: such an edge is two
    double outlier = 6;                     // standard deviations
    ContrastChange change;
};

/// A piece of an edge as it was read.
struct EdgePiece {
    CornerEdge edge = x_edge;
    double start = 0, length = 0;  // px along the edge, from the corner
    LineStretch stretch;
    LightProfile profile;
    EdgeStep step;
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();  // of the piece, camera frame, in ceiling distances
    Vector5d slope = Vector5d::Zero();                 // d(offset wanted) / d(unknowns), px
    double lift = 0;                                   // px of offset per ceiling distance that the whole corner rises
    bool read = false;                                 // its light could be read
    bool seen = false;                                 // there is a step where it should be
};

/// How an edge's pieces are read.
struct EdgeLook {
    double blur = 0;     // px
    double reach = 0;    // blurs
    double length = 16;  // px, of the pieces
    StepModel model = StepModel::full;
};

struct CornerFit {
    CornerView view;
    Matrix5d information = Matrix5d::Zero();  // of rotation (about the corner's axes, rad) and place
    bool look_known = false;                  // the edges' look is that of the last frame: need not be found again
    int counted = 0;                          // pieces that have a say
    double spread = 1;                        // mean square of the seen pieces' offsets over their variances
    std::array<EdgeKind, 3> kind = {EdgeKind::step, EdgeKind::step, EdgeKind::step};
    std::array<EdgeLook, 3> look;
    std::array<bool, 3> shared = {false, false, false};  // single pieces hardly tell: those of this edge share their contrast
    std::vector<EdgePiece> pieces;
};

class CornerFitter {
public:
    explicit CornerFitter(const CameraModel& model, const CornerFitSettings& settings = {});

    /// Fits from `fit.view`, which must be within about `capture` px of the truth along all edges. `capture` 0: the last fine steps only.
    /// False if the edges do not hold the corner: too little of them is seen. No allocation if `fit` is reused.
    bool refine(LumaView frame, double wall_angle, double capture, CornerFit& fit) const;
    /// The two halves of it: the wide steps, quick, after which the pieces tell whether there is a corner at all; and the fine ones.
    bool approach(LumaView frame, double wall_angle, double capture, CornerFit& fit) const;
    bool finish(LumaView frame, double wall_angle, CornerFit& fit) const;
    /// Instead of finish(), for soft pictures and faint or crowded edges: long pieces, read closely, of a blur that is taken as known.
    bool finish_softly(LumaView frame, double wall_angle, CornerFit& fit) const;

    /// Has all edges read like this, but creases, which look the same however they are read.
    void look_like(const EdgeLook& look, CornerFit& fit) const;

    /// Reads all pieces at the fit's view and look without moving it; only every `skip`-th row of each.
    void read(LumaView frame, double wall_angle, int skip, CornerFit& fit) const;

    /// Reads all pieces at the fit's view as finish() does in the end, for how exact that view is. False if they do not hold it.
    bool weigh(LumaView frame, double wall_angle, CornerFit& fit) const;

    const LightTable& light() const { return light_; }

private:
    Vector5d sum_up(double gate, CornerFit& fit) const;
    void leave_open_offset(CornerEdge edge, double gate, CornerFit& fit, Vector5d& pull) const;
    std::optional<Eigen::LDLT<Matrix5d>> factored(const CornerFit& fit) const;
    bool step(double wall_angle, double gate, CornerFit& fit) const;
    struct Reading {
        double noise = 0, plainness = 0;  // medians over the pieces that are seen, and over all
        std::size_t seen = 0;
    };
    Reading reading_of(CornerEdge edge, CornerFit& fit) const;
    void choose_reach(CornerEdge edge, CornerFit& fit) const;
    void judge(const CornerFit& fit, EdgePiece& piece) const;
    void leave_out_what_follows(CornerEdge edge, CornerFit& fit) const;
    void share_contrast(CornerEdge edge, CornerFit& fit) const;
    void update_blur(CornerFit& fit) const;

    CameraModel model_;
    CornerFitSettings settings_;
    LightTable light_;
};

/// How many times more the pieces scatter than their light tells; 1 where that may be chance.
double excess_scatter(const CornerFit& fit);

/// How the view moves with the intrinsics with which it was found.
CornerByIntrinsics view_by_intrinsics(const CameraModel& model, const CornerFit& fit, const CornerFitSettings& settings);

/// What the pieces say about each edge, for judging and drawing. A piece is seen if its step is where it should be within its own error and
/// `tolerance` px.
struct EdgeSupport {
    double visible = 0;                             // px inside the picture
    double seen = 0;                                // px of it that the picture confirms
    double first = 1e9;                             // px from the corner to the first that is seen
    Eigen::Vector2d end = Eigen::Vector2d::Zero();  // px, of the last seen
};
std::array<EdgeSupport, 3> edge_support(const CornerFit& fit, double tolerance);

}  // namespace roomfix
