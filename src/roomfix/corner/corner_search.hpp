// Which three lines of a picture are a room's corner? Every Y that a corner could draw, scored by how much of it the picture shows.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "roomfix/corner/corner_geometry.hpp"
#include "roomfix/corner/faint_edge.hpp"
#include "roomfix/corner/line_search.hpp"
#include "roomfix/imaging/luma.hpp"

namespace roomfix {

struct CornerSearchSettings {
    // Lengths in px are those of a picture 640 px wide.
    double meeting = 5;        // px: three lines meet within this of a point
    double least_angle = 18;   // deg between two of them
    double border = 6;         // px: a corner lies this far inside the picture
    double near_corner = 60;   // px: here a line must start, and must not go on beyond the corner
    double least_near = 0.35;  // part of that which carries edge points
    double steepest = 35;      // deg: the walls' edge leans at most this much from the picture's vertical, where nothing else is known
    double farthest = 8;       // ceiling distances from the corner, along the floor
    std::size_t most = 24;     // candidates
    std::size_t most_junctions = 8;
    double faint = 12;  // squared standard deviations, in all, that the light steps along a faint line
};

/// Where down is in the camera's frame, if that is known.
struct Gravity {
    Eigen::Vector3d down = Eigen::Vector3d::UnitY();
    double sigma = 0.05;  // rad
};

struct CornerCandidate {
    CornerView view;
    double wall_angle = 0;
    double score = 0;                      // px of edge points along the three lines, less what speaks against
    std::array<int, 3> lines = {0, 0, 0};  // of the search
    EdgeKind wall_edge_kind = EdgeKind::step;
};

/// Two lines that meet where a corner might be whose third line is too faint for a line of its own.
struct CornerJunction {
    Eigen::Vector2d point = Eigen::Vector2d::Zero();                                                 // normalised picture
    std::array<Eigen::Vector2d, 2> directions = {Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero()};  // away from it
    double score = 0;
    std::array<int, 2> lines = {0, 0};
};

/// Whether its lines start as a corner's x and y edges do, within `tolerance` (rad).
bool starts_edges(const CornerJunction& junction, const CornerRays& rays, double tolerance);

struct CornerSearchResult {
    std::vector<CornerCandidate> candidates;  // the best first
    std::vector<CornerJunction> junctions;    // the best first
};

class CornerSearch {
public:
    /// `wall_angles`: the angles between walls that the site has, rad.
    CornerSearch(const CameraModel& model, const std::vector<double>& wall_angles, const CornerSearchSettings& settings = {});

    /// Every Y that the lines make, and every pair of lines that lacks a third.
    void find(const std::vector<SceneLine>& lines, const std::optional<Gravity>& gravity, CornerSearchResult& result) const;

    /// Looks in the picture itself for the third line of each junction: a faint step of light is plain once it is summed up along a line. A crease may only be
    /// the edge between the walls. Replaces `result.candidates`.
    void complete(LumaView frame, const LightTable& light, const FaintEdges& edges, EdgeKind kind, const std::optional<Gravity>& gravity,
                  CornerSearchResult& result) const;

private:
    struct HalfLine {
        double sign = 1;       // of SceneLine::along()
        double covered = 0;    // length with edge points, up to the picture's border
        double near_part = 0;  // of the part beside the point
        double beyond = 0;     // part of the other side, right behind the point, that carries edge points, too
    };
    std::optional<HalfLine> half_line(const SceneLine& line, const Eigen::Vector2d& point) const;
    double score_of(const HalfLine& half) const;
    bool in_picture(const Eigen::Vector2d& point) const;
    void try_triple(const std::vector<SceneLine>& lines, const std::array<int, 3>& which, const std::optional<Gravity>& gravity,
                    std::vector<CornerCandidate>& candidates) const;
    void add_solutions(const CornerRays& rays, EdgeKind third, double score, const std::array<int, 3>& which, const std::optional<Gravity>& gravity,
                       std::vector<CornerCandidate>& candidates) const;
    std::vector<Eigen::Vector2d> faint_directions(LumaView frame, const LightTable& light, const FaintEdges& edges, EdgeKind kind,
                                                  const CornerJunction& junction, const std::optional<Gravity>& gravity) const;

    CameraModel model_;
    std::vector<double> wall_angles_;
    CornerSearchSettings settings_;
    double focal_;
};

}  // namespace roomfix
