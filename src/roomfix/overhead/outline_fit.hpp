// Fits a robot's pose to the edges that its outline leaves in a picture, at subpixel level.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "roomfix/imaging/background_model.hpp"
#include "roomfix/overhead/silhouette.hpp"
#include "roomfix/site/body_parts.hpp"
#include "roomfix/site/site.hpp"

namespace roomfix {

/// A frame with the background that belongs to it.
struct FrameEvidence {
    LumaView frame;
    const BackgroundModel* background = nullptr;
    const Foreground* foreground = nullptr;
    const BitMask* mask = nullptr;                 // the foreground after opening and closing
    const std::vector<Polyline>* walls = nullptr;  // that nobody sees through; null: none
};

struct OutlineFitSettings {
    int samples = 64;            // at most this many along the outline
    double edge_noise = 0.10;    // px, of one edge sample on top of the pixel noise: interpolation, small structure
    double common_noise = 0.06;  // px, shared by all samples of one edge: blur, gamma, rounded edges
    double disturbance = 0.02;   // part of the floor's light by which shading and reflections move an edge's levels
    double inset_noise = 0.12;   // px, shared by the whole outline: bright sides look larger than they are
    double floor_noise = 0.05;   // px, more for the edges on the floor: contact shadow and reflection
    int first_reach = 8;         // px to both sides of the outline in the first round
    int last_reach = 4;          // px in the last round
    double first_scale = 4;      // px: readings off by more lose their say, in the first round
    double last_scale = 0.8;     // px, in the last round
    int coarse_rounds = 2;       // with half of the samples, ever nearer to the last settings
    int rounds = 7;              // at most; fewer once the pose stays
    double edge_shown = 0.85;    // probability that a sample of a robot's outline shows an edge ...
    double edge_chance = 0.25;   // ... and that a sample anywhere else in a furnished picture does
    double edge_length = 8;      // px along an outline that say as much as one independent sample
    // A robot that is the solid of its description, beside one that is only about so large: Beta distributions of the part of the outline that
    // shows an edge, and how much wider than the stated noise the edges of the second scatter.
    double exact_shown = 17, exact_bare = 3;
    double rough_shown = 3, rough_bare = 2;
    double rough_scatter = 1.45;
    // A robot about as described that stands at the pose, beside one that stands elsewhere or is turned otherwise, which the fit has brought to whatever
    // edges there are: the same of the part that shows an edge, and how much wider these scatter.
    double right_shown = 7.5, right_bare = 2.5;
    double wrong_shown = 8.5, wrong_bare = 11.5;
    double wrong_scatter = 1.6;
    double side_scatter = 0.33;  // part of the samples whose scatter tells the robot from another thing: those of a side that is not quite as described are
                                 // off alike
};

struct OutlineFit {
    Pose2 pose;
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();                          // x, y, yaw; pixels and calibration together
    Eigen::Matrix3d pixel_covariance = Eigen::Matrix3d::Identity();                    // without the calibration's part
    Eigen::Matrix<double, 3, 6> by_calibration = Eigen::Matrix<double, 3, 6>::Zero();  // how the pose moves with the view's six independent errors
    Silhouette silhouette;
    int visible = 0;          // samples inside the image and outside `others`, before walls
    int supported = 0;        // samples with an edge where the outline says
    int covered = 0;          // samples with foreground on both sides: the robot does not end here
    int bare = 0;             // samples with background on both sides: hidden, or not there
    int ambiguous = 0;        // samples with an edge that may as well be the border of something in front
    int total = 0;            // samples along the whole outline
    int into_shadow = 0;      // supported samples on the floor beside which there may be no more than a shadow
    double left_shown = 1;    // part of the samples on the left side that show an edge within a pixel; 1 where none is in view
    double right_shown = 1;   // likewise
    double residual = 0;      // rms of the supported samples in their standard deviations
    double score = 0;         // -1..1: how well the picture agrees
    double edges = 0;         // nats by which the edges found speak for the outline, against edges that lie anywhere by chance
    double exact = 0;         // nats by which the picture shows the very solid, and not a robot that is only about so large
    double right = 0;         // nats by which the picture shows a robot about as described at this pose, and not at another one
    double present = 0;       // nats by which it shows the robot at about this pose, and not another thing
    bool determined = false;  // enough edges to fix all unknowns
};

/// Squared Mahalanobis distance of the fit's place from another one that has its own covariance (x, y, yaw).
double squared_distance(const OutlineFit& fit, const Pose2& pose, const Eigen::Matrix3d& covariance);

/// Fits x, y and yaw, starting at `start`, to the edges of frame / background along the predicted outline. Edges between lit
/// or shadowed floor and something else count; inside `others` (outlines of other robots, px) and behind walls nothing is looked at.
/// The covariance holds pixel noise, errors shared along each edge, the body's size error and the view's calibration.
/// `parts`: of one body, up to `most_parts`; only where all of them together end is an edge expected. What is said of the whole body (radius,
/// symmetry, size_sigma) is taken from the first one. The silhouette of the result is that of the first one, too.
OutlineFit fit_outline(const FrameEvidence& evidence, const View& view, std::span<const ShapePoints> parts, const Pose2& start,
                       std::span<const Silhouette> others, const OutlineFitSettings& settings = {});
/// Of a body of one part.
OutlineFit fit_outline(const FrameEvidence& evidence, const View& view, const ShapePoints& shape, const Pose2& start, std::span<const Silhouette> others,
                       const OutlineFitSettings& settings = {});

/// A shadow before the body may have a border just as straight as the body's own lower edge. If there is another edge farther in along most of
/// the lower edges that `fit` took for the body's: the pose at which they would be the body's. `view` and `parts` as for the fit.
std::optional<Pose2> pose_behind_shadow(const FrameEvidence& evidence, const View& view, std::span<const ShapePoints> parts, const OutlineFit& fit,
                                        const OutlineFitSettings& settings = {});

/// For bodies whose outline is no exact solid's (people, loads): takes the pose as it is, found by its area, and states how
/// uncertain it is when each side of the outline is off by a part of the body's size in the picture.
OutlineFit fit_area(const FrameEvidence& evidence, const View& view, const ShapePoints& shape, const Pose2& pose, const OutlineFitSettings& settings = {});

}  // namespace roomfix
