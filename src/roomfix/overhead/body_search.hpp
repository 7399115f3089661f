// Finds a body on the floor in what one or several cameras see at the same moment.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "roomfix/overhead/place_score.hpp"

namespace roomfix {

/// One camera's part of a moment.
struct SeenBy {
    const View* view = nullptr;
    const Evidence* evidence = nullptr;
};

struct BodySearchSettings {
    PlaceScoreSettings score;
    double coarse_step = 0.45;     // of the body's radius, between places that are tried first
    double least_step = 0.05;      // m, of the coarse places
    int most_places = 40000;       // tried at first; the step grows where the floor is larger
    double farthest = 8;           // times the camera's height: nobody locates robots beyond
    int most_climbs = 8;           // places that are refined
    int spread_samples = 96;       // drawn to measure how far the place is uncertain
    int spread_rounds = 4;
    double most_information = 40;  // nats: a body that is not exactly as described tells places apart no better than that
    double odds_of_clutter = 12;   // nats: what explains a picture as well as a body does by chance
    double least_place_sigma = 0.003;  // m
};

/// Where a body may stand.
struct BodyPlace {
    Pose2 pose;
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();                          // x, y, yaw; with what is uncertain of body and calibration
    Eigen::Matrix<double, 3, 6> by_calibration = Eigen::Matrix<double, 3, 6>::Zero();  // where one camera alone sees it
    double log_ratio = 0;                                                              // nats, summed over the cameras
    double weight = 0;                                                                 // of all places, 0..1
    double probability = 0;                                                            // that it is a body and no clutter
    double filled = 0;                                                                 // part of its pixels that differ from the background
    std::vector<char> seen;                                                            // of each camera: it has the body in its picture and shows it
};

/// Keeps its working memory.
class BodySearch {
public:
    explicit BodySearch(const BodySearchSettings& settings = {}) : settings_(settings) {}

    /// The best places, best first, none likelier than clutter: empty. `near`: looks only there, with its covariance.
    std::vector<BodyPlace> find(std::span<const SeenBy> cameras, const Body& body);

    /// Score of one pose in all cameras together, nats.
    double score(std::span<const SeenBy> cameras, const Body& body, const Pose2& pose);

private:
    struct Candidate {
        Pose2 pose;
        double score = 0;
    };
    struct Spread {
        Eigen::Vector3d mean = Eigen::Vector3d::Zero();  // from the best pose: m, m, rad
        Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();
    };
    void search_floor(std::span<const SeenBy> cameras, const Body& body);
    Candidate climb(std::span<const SeenBy> cameras, const Body& body, Candidate start, double step);
    Spread spread_around(std::span<const SeenBy> cameras, const Body& body, const Candidate& best, double trust);
    BodyPlace measure(std::span<const SeenBy> cameras, const Body& body, const Candidate& best);

    BodySearchSettings settings_;
    BodyMask mask_;
    std::vector<Candidate> candidates_;
};

}  // namespace roomfix
