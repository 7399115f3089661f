#include "roomfix/site/mesh_parts.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "roomfix/geometry/solid_hull.hpp"
#include "roomfix/site/body_parts.hpp"
#include "roomfix/site/mesh_cut.hpp"
#include "roomfix/site/mesh_pieces.hpp"

namespace roomfix {
namespace {

constexpr std::size_t most_pieces = 30;   // before cuts
constexpr double worth_of_piece = 0.08;   // part of a piece's hull that a cut has to save
constexpr double worth_of_whole = 0.005;  // and of all hulls together
constexpr double looks_hollow = 0.7;      // part of its hull that a solid without cuts fills
constexpr double exact = 0.002;           // m

struct Piece {
    Chunk chunk;
    double hull = 0;  // m^3
    Cut cut;          // the next one, if it is worth it
};

Piece piece_of(Chunk chunk) {
    Piece piece;
    piece.hull = hull_volume(chunk);
    piece.cut = best_cut(chunk);
    piece.chunk = std::move(chunk);
    return piece;
}

bool worth_it(double saving, double hull, double all) { return saving > worth_of_piece * hull && saving > worth_of_whole * all; }

/// No single cut saves air in a ring or a frame; a cut through the middle and what can be saved of its halves does.
std::optional<Cut> cut_through_the_middle(const Piece& piece, double all) {
    if (piece.hull < worth_of_whole * all) return std::nullopt;
    if (piece.chunk.uncut() && enclosed_volume(piece.chunk.surface) > looks_hollow * piece.hull) return std::nullopt;
    Cut best;
    for (int axis = 0; axis < 3; ++axis) {
        Cut cut{axis, box_of(piece.chunk.surface).center()[axis], 0};
        const auto [below, above] = cut_apart(piece.chunk, cut);
        cut.saving = best_cut(below).saving + best_cut(above).saving;
        if (cut.saving > best.saving) best = cut;
    }
    if (!worth_it(best.saving, piece.hull, all)) return std::nullopt;
    return best;
}

ConvexPart part_of(const Chunk& chunk) {
    Supports supports(Supports::Directions::many);
    for (const Eigen::Vector3d& p : chunk.surface.corners) supports.add(p);
    for (const Eigen::Vector3d& p : chunk.inner) supports.add(p);
    return {supports.corners(exact, most_points_of_part)};
}

}  // namespace

std::vector<ConvexPart> mesh_parts(const TriangleMesh& mesh) {
    std::vector<Piece> open;
    double all = 0;
    for (TriangleMesh& piece : pieces_of(welded(mesh), most_pieces)) {
        open.push_back(piece_of(chunk_of(std::move(piece))));
        all += open.back().hull;
    }
    std::vector<ConvexPart> parts;
    while (!open.empty()) {
        const auto next = std::max_element(open.begin(), open.end(), [](const Piece& a, const Piece& b) { return a.cut.saving < b.cut.saving; });
        Piece piece = std::move(*next);
        open.erase(next);
        std::optional<Cut> cut;
        if (open.size() + parts.size() + 2 <= most_model_parts) {
            cut = worth_it(piece.cut.saving, piece.hull, all) ? piece.cut : cut_through_the_middle(piece, all);
        }
        if (!cut) {
            parts.push_back(part_of(piece.chunk));
            continue;
        }
        auto [below, above] = cut_apart(piece.chunk, *cut);
        for (Chunk* side : {&below, &above}) {
            if (!side->surface.triangles.empty()) open.push_back(piece_of(std::move(*side)));
        }
    }
    std::erase_if(parts, [](const ConvexPart& part) { return part.points.size() < 3; });
    return parts;
}

}  // namespace roomfix
