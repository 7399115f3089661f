// Finds a body on the floor in what one or several cameras see at the same moment.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "roomfix/observation/silhouette_observation.hpp"
#include "roomfix/overhead/floor_grid.hpp"
#include "roomfix/overhead/place_score.hpp"

namespace roomfix {

struct BodySearchSettings {
    PlaceScoreSettings score;
    double samples_together = 80;      // of a body in each of several cameras: a near one must not outvote the others, since what the description leaves
                                       // out is as large in its picture as the body
    double coarse_step = 0.45;         // of the body's radius, between places that are tried first
    double coarse_step_of_look = 0.3;  // ... where the look is known: it has narrow peaks
    double least_step = 0.03;          // m, of the coarse places
    int most_places = 40000;           // tried at first; the step grows where the floor is larger
    double farthest = 8;               // times the camera's height: nobody locates robots beyond
    double least_other = 0.06;         // part of what the body covers that must show something else, in the box around it, for a closer look
    double more_than_by_chance = 2;    // ... or, where edges tell whether it is the robot, so many times what differs in such a box by chance, ...
    double least_samples = 6;          // ... and so many independent pixels more
    int most_climbs = 12;              // places that are refined
    int most_by_look = 24;             // places at which the whole look is compared, where it is known: as many by how much differs, as by
                                       // some spots of the look
    std::size_t most_aligned = 96;     // places found by some spots of the look, of which the best are kept when each is where they agree best nearby
    std::size_t most_from_beside = 3;  // of the places found by the look: climbed from all sides, too
    std::size_t coarse_spots = 80;     // of the look, compared all over the floor
    int spread_samples = 64;           // drawn to measure how far the place is uncertain
    int spread_rounds = 3;             // each draws them where the one before found the spread to be
    double most_information = 40;      // nats: a body that is not exactly as described tells places apart no better than that
    double odds_of_clutter = 12;       // nats: what explains a picture as well as a body does by chance
    double lasting = 0.65;             // part of the variance of a place that stays from frame to frame, beside what the calibration makes of it
    double least_place_sigma = 0.003;  // m
    double turn_of_gaps = 1;           // rad: how uncertain the direction of a body is that leaves all of its pixels open, beside what explains them as well
};

/// Where a body may stand.
struct BodyPlace {
    Pose2 pose;
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();                          // x, y, yaw; with what is uncertain of body and calibration
    Eigen::Matrix<double, 3, 6> by_calibration = Eigen::Matrix<double, 3, 6>::Zero();  // by the errors of the calibration, where one camera alone shows it
    LastingError lasting;
    double log_ratio = 0;    // nats, summed over the cameras
    double weight = 0;       // of all places, 0..1
    double probability = 0;  // that it is a body and no clutter
    double filled = 0;       // part of its pixels that differ from the background
    double body_like = 0;    // nats, at most 0: how much less differs than where a body usually stands
    std::vector<char> seen;  // of each camera: it has the body in its picture and shows it
};

/// A pose with its score in all cameras together, nats.
struct BodyCandidate {
    Pose2 pose;
    double score = 0;
    double prior = 0;  // nats by which such a robot is likelier to stand here than anywhere, from what was seen before
    double odds = 0;   // nats by which the body stands here, and neither nothing nor a thing of any shape; only where BodySearch::weigh() was asked

    double total() const { return score + prior; }
};

/// Keeps its working memory.
class BodySearch {
public:
    explicit BodySearch(const BodySearchSettings& settings = {});

    /// Poses that explain the pictures better than nothing does, apart from each other, best first.
    std::vector<BodyCandidate> candidates(std::span<const SeenBy> cameras, const Body& body);
    /// Scores candidates anew after what is seen has changed, and sorts them; those that explain nothing any more are left out.
    void score_again(std::span<const SeenBy> cameras, const Body& body, std::vector<BodyCandidate>& candidates);
    /// The best of the candidates as places with their covariances and weights, best first.
    std::vector<BodyPlace> places(std::span<const SeenBy> cameras, const Body& body, const std::vector<BodyCandidate>& candidates);

    /// Score of one pose in all cameras together, nats.
    double score(std::span<const SeenBy> cameras, const Body& body, const Pose2& pose, bool coarse = false);
    /// Nats, at most 0, for a body's being at a pose where its score speaks against it. Of a body that is partly hidden by something known the rest may be
    /// hidden, too, with a probability as large as that part: outlines are known no better.
    double absence(std::span<const SeenBy> cameras, const Body& body, const Pose2& pose);
    /// Fills the candidates' odds.
    void weigh(std::span<const SeenBy> cameras, const Body& body, std::vector<BodyCandidate>& candidates);
    double odds(std::span<const SeenBy> cameras, const Body& body, const Pose2& pose);
    /// Nats by which a body stands at a pose, and neither nothing nor a thing of any shape.
    double odds_of_shape(std::span<const SeenBy> cameras, const Body& body, const Pose2& pose);
    /// How well the body's look agrees with what the cameras see at a pose, nats per spot; nothing where it is not known, or hardly in view.
    /// Every `step`-th spot is compared.
    std::optional<double> agreement(std::span<const SeenBy> cameras, const Body& body, const Pose2& pose, std::size_t step = 1);
    /// Log odds that what the cameras see at a pose has the robot's colours and not those of clutter; nothing where no look is known, or hardly in view.
    std::optional<double> odds_of_look(std::span<const SeenBy> cameras, const Body& body, const Pose2& pose);
    /// What explains the pictures near a pose that is known to `spread` (m^2, rad^2; x, y, yaw). `rough`: only its score matters, not where exactly it is.
    BodyCandidate near(std::span<const SeenBy> cameras, const Body& body, const Pose2& pose, const Eigen::Matrix3d& spread, bool rough = false);
    /// The best pose near one, in steps of `step` (m), which is halved so many times.
    BodyCandidate climb(std::span<const SeenBy> cameras, const Body& body, BodyCandidate start, double step, int halvings = 5, bool coarse = false);

    /// Part of a score that counts: all samples of a body share the errors of its description, so that however many they are, they tell only so much.
    double trust_in(double score) const;

    /// A place with its covariance and its probability against clutter.
    BodyPlace measure(std::span<const SeenBy> cameras, const Body& body, const BodyCandidate& best);

private:
    struct Spread {
        Eigen::Vector3d mean = Eigen::Vector3d::Zero();  // from the best pose: m, m, rad
        Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();
    };
    void prepare_near(std::span<const SeenBy> cameras, const Body& body, const Pose2& pose);
    double score_near(std::span<const SeenBy> cameras, const Body& body, const Pose2& pose, bool coarse = false);
    void search_floor(std::span<const SeenBy> cameras, const Body& body);
    double coarse_step(const Body& body) const;
    double coarse_agreement(std::span<const SeenBy> cameras, const Body& body, const Pose2& pose);
    void align_looks(std::span<const SeenBy> cameras, const Body& body);
    void try_looks(std::span<const SeenBy> cameras, const Body& body, const Eigen::Vector2d& place);
    bool worth_a_look(std::span<const SeenBy> cameras, const Body& body, std::span<const FloorGrid::Box> boxes) const;
    const FloorGrid& grid_of(std::span<const SeenBy> cameras, const Body& body);
    void compare_looks(std::span<const SeenBy> cameras, const Body& body);
    BodyCandidate finish_climb(std::span<const SeenBy> cameras, const Body& body, BodyCandidate climbed, double step);
    BodyCandidate climb_from_beside(std::span<const SeenBy> cameras, const Body& body, BodyCandidate best);
    static void add_rivals(std::vector<BodyPlace>& places, const Body& body);
    Spread spread_around(std::span<const SeenBy> cameras, const Body& body, const BodyCandidate& best, double trust, double width, int rounds);
    BodySearchSettings settings_;
    PlaceMemory memory_;
    std::vector<NearBody> near_;  // of each camera
    std::vector<FloorGrid> grids_;
    std::vector<Eigen::Vector3d> units_;  // normal numbers, evenly spread, for samples of poses
    std::vector<BodyCandidate> candidates_;
    std::vector<BodyCandidate> by_look_;
};

}  // namespace roomfix
