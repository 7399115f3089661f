// Which of the space that moves with a robot is filled: a grid of cells, learned from what cameras see at known poses.
#pragma once

#include <vector>

#include "roomfix/overhead/body_search.hpp"

namespace roomfix {

struct OccupancySettings {
    int cells_across = 24;       // over the rough body's diameter
    int cells_up = 24;           // over its height
    double margin = 0.5;         // of its width, around it: as much larger may the real one be ...
    double margin_up = 0.15;     // ... and of its height
    double filled = 0.75;        // probability that a pixel of the body differs from the background ...
    double passing = 0.35;       // ... and that one beside it does, since the rest of the body is near; both are learned at each height,
    double weight = 20;          // these counting as so many sights of a cell
    double beyond = -1.0;        // log odds beyond the rough body, before anything was seen
    double least_growth = 1.15;  // layers whose hulls differ by less are one part
    std::size_t most_parts = 12;
};

/// A robot at a pose, seen by some cameras.
struct BodySight {
    std::size_t moment = 0;
    Pose2 pose;
};

/// What cameras saw at one moment.
struct BodyMoment {
    std::vector<SeenBy> cameras;
};

/// The filled cells' log odds; `round`: the body looks the same from all sides, and so does what is learned.
class Occupancy {
public:
    /// Of all that the sights show. `rough`: what is known before.
    Occupancy(const std::vector<BodyMoment>& moments, const std::vector<BodySight>& sights, const Body& rough, bool round, const OccupancySettings& settings);

    /// Hulls of the filled cells, layer by layer, joined where they are alike; empty if there are none.
    std::vector<ConvexPart> parts() const;
    /// m: half the thickness of what might or might not be filled.
    double size_sigma() const;

private:
    std::size_t index(int x, int y, int z) const { return static_cast<std::size_t>((z * across_ + y) * across_ + x); }
    double at(int x, int y, int z) const { return log_odds_[index(x, y, z)]; }
    Eigen::Vector3d middle(int x, int y, int z) const { return {(x + 0.5) * cell_ - reach_, (y + 0.5) * cell_ - reach_, (z + 0.5) * layer_}; }
    void make_round();
    void weigh_layer(int z);
    std::vector<Eigen::Vector2d> layer_hull(int z) const;

    OccupancySettings settings_;
    int across_ = 0;    // cells along x and y
    int up_ = 0;        // along z
    double reach_ = 0;  // m from the origin to the grid's sides
    double cell_ = 0;   // m
    double layer_ = 0;  // m
    bool round_ = false;
    std::vector<Evidence::Sums> seen_;  // of each cell, in all sights
    std::vector<double> before_;        // log odds of each cell, as known before
    std::vector<double> log_odds_;      // and as learned
};

}  // namespace roomfix
