// A camera on a robot looks up: from a frame to the landmarks in it.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "roomfix/ceiling/floor_fit.hpp"
#include "roomfix/ceiling/triangle_search.hpp"
#include "roomfix/imaging/bright_spots.hpp"
#include "roomfix/imaging/components.hpp"
#include "roomfix/imaging/spot_fit.hpp"
#include "roomfix/observation/landmark_observation.hpp"
#include "roomfix/site/site.hpp"

namespace roomfix {

struct CeilingSettings {
    BrightSpotSettings bright;
    SpotFitSettings fit;
    double unknown_tilt = 0.026;   // rad: how far a mount without a covariance may be off (1.5 deg)
    int rough_radius = 2;          // px: window of the centroid before the fit
    double rough_sigma = 0.35;     // px, of that centroid
    double largest_misfit = 0.35;  // px: rms of a landmark's points about the best pose (and what the tilt adds)
    double least_contrast = 30;    // grey levels: the panel between two LEDs must be darker than both by this
    double narrowest = 0.4;        // px, width of a spot
    double widest = 2.6;
    double least_noise = 0.1;  // of the spots' fits: variance of their residuals about what is expected of a camera
    double largest_noise = 60;
    double suspicious_noise = 3;  // a spot that fits worse, or differs from its fellows, is fitted again with what they tell
    double glare_reach = 2.8;     // widths: window of such a fit
    double glare_sigma = 0.02;    // px: what a lamp beside a spot may still do to it
    double model_sigma = 0.005;   // px: real spots are not quite Gaussian
    int noise_memory = 50;        // frames that the noise is averaged over
    double largest_ratio = 4;     // between the brightnesses of a landmark's LEDs
    int largest_blob = 60;        // px
    int most_spots = 128;
};

/// A bright spot that is no LED, or a LED whose landmark is not whole.
struct RejectedSpot {
    Eigen::Vector2f pixel;
};

struct CeilingResult {
    std::vector<LandmarkObservation> landmarks;
    std::vector<RejectedSpot> rejected;
    std::string reason;  // why there is none; empty otherwise
};

class CeilingObserver {
public:
    /// `landmarks` with LED triangles among them; frames must have the model's size.
    CeilingObserver(const CameraOnRobot& camera, bool mount_calibrated, const std::vector<SiteLandmark>& landmarks, const CeilingSettings& settings = {});

    /// No allocation in steady state, as long as `result` is reused.
    void observe(LumaView frame, CeilingResult& result);

private:
    struct Shape {
        int index;  // of landmark_shapes()
        double height;
        TriangleShape triangle;
        double largest_misfit;  // px
        std::array<Eigen::Vector2d, 3> own;
    };
    struct Candidate {
        TriangleMatch match;
        std::size_t shape;
    };
    struct Spot {
        Eigen::Vector2d centroid;
        bool fitted = false;
        std::optional<SpotFit> fit;
        bool used = false;
    };
    void find_spots(LumaView frame);
    void find_candidates();
    /// A landmark's LEDs with their places.
    struct Leds {
        std::array<SpotFit, 3> fits;
        std::array<double, 3> extra_sigma = {0, 0, 0};  // px
    };
    const std::optional<SpotFit>& fitted(LumaView frame, int spot);
    std::optional<Leds> fit_leds(LumaView frame, const TriangleMatch& match);
    bool look_like_leds(LumaView frame, const Leds& leds) const;
    bool at_distances(const Shape& shape, const Leds& leds) const;
    bool verify(LumaView frame, const Candidate& candidate, LandmarkObservation& observation);
    bool dark_between(LumaView frame, const std::array<SpotFit, 3>& fits) const;
    std::string reason_for_nothing(const CeilingResult& result) const;

    CameraOnRobot camera_;
    CeilingSettings settings_;
    std::vector<Shape> shapes_;
    // A camera's noise and blur stay what they are: means over the last frames know them better than one frame's few pixels.
    double noise_ = 1;  // of the spots' fits
    double width_ = 0;  // px, of clean spots; 0: not known yet
    int frames_known_ = 0;
    // Working memory, kept between frames.
    BitMask mask_;
    ComponentFinder finder_;
    std::vector<Spot> spots_;
    std::vector<Eigen::Vector2d> places_;
    std::vector<TriangleMatch> matches_;
    std::vector<Candidate> candidates_;
};

}  // namespace roomfix
