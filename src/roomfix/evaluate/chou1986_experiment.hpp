// The experiment of Chou and Tsai 1986: 16 places before a corner, six pictures each; as published, ours, the bound. And the paper's error
// study, and the same in furnished rooms.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "roomfix/base/result.hpp"
#include "roomfix/evaluate/consistency.hpp"
#include "roomfix/evaluate/line_chart.hpp"
#include "roomfix/evaluate/simulated_calibration.hpp"
#include "roomfix/observation/corner_observation.hpp"
#include "roomfix/simulate/room_shots.hpp"

namespace roomfix {

struct Chou1986Options {
    std::uint64_t seed = 1;
    int seeds = 1;          // each with its own rooms, looks and noise
    bool published = true;  // the published method, too
    BoardPictures board;    // from which the lens is calibrated; 0 shots: it is known exactly
};

struct Chou1986Trial {
    int place = 0;
    double ceiling_distance = 0;  // m
    double distance = 0;          // m, from the camera to the corner
    CornerView truth;
    std::optional<CornerObservation> ours;
    Vector5d error = Vector5d::Zero();  // rotation (rad) and place of the truth against ours
    std::optional<CornerView> published;
    Matrix5d covariance = Matrix5d::Zero();                   // of ours, with the lens's errors:
    CornerByIntrinsics by_lens = CornerByIntrinsics::Zero();  // independent ones of sigma 1 enter like this
    int lens = 0;                                             // which of the experiment's
    Matrix5d bound = Matrix5d::Zero();                        // covariance; with the lens's errors where there is a fix
    std::string reason;
};

struct Chou1986Report {
    Chou1986Options options;
    std::vector<Chou1986Trial> trials;

    int lost() const;
    int published_lost() const;
    /// Position errors over the distance to the corner: mean, largest and root mean square.
    double mean_error() const;
    double largest_error() const;
    double rms_error() const;
    double published_mean_error() const;
    double published_largest_error() const;
    double bound_rms() const;
    /// Mean angle of the rotation's error, rad; root mean square and the bound's.
    double mean_rotation() const;
    double rotation_rms() const;
    double rotation_bound() const;
    double mean_nees() const;
    NeesBand nees_band() const;  // fixes with the same lens err together
};

/// An error if the lens could not be calibrated.
Result<Chou1986Report> run_chou1986(const Chou1986Options& options, const std::function<void(double)>& progress = {});

/// The paper's Fig. 17(a) as a table: per place the mean, the standard deviation and the error percentage of X_c and Y_c.
std::string chou1986_table(const Chou1986Report& report);

/// The paper's error study: how far errors of the three lines' angles (0.1 deg each) and of the image centre (1 px) move X_c and Y_c, along a
/// walk parallel to a wall, Y_c = Z_c = 2 m. In percent.
LineChart chou1986_error_study();

/// Furnished rooms. A picture has a visible corner if light changes by `visible_contrast` grey levels or more along at least
/// 80, 60 and 20 px of its three edges, the walls' grain and the noise left out.
struct ClutterReport {
    int pictures = 0, visible = 0;
    int good = 0;   // of the visible: within 1 % of the distance
    int wrong = 0;  // of all: off by more than 5 %, and believed (weight above one half)
    int none = 0;   // of the visible: no fix
    std::string first_wrong;
};
constexpr double visible_contrast = 4;
ClutterReport run_cluttered(int pictures, std::uint64_t seed, Walls walls = Walls::plain, const std::function<void(double)>& progress = {});
/// How many pictures without a corner give one.
int run_cornerless(int pictures, std::uint64_t seed, Walls walls = Walls::plain, const std::function<void(double)>& progress = {});

}  // namespace roomfix
