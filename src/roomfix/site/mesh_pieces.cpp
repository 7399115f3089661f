#include "roomfix/site/mesh_pieces.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <numeric>
#include <unordered_map>
#include <utility>

namespace roomfix {
namespace {

struct CellHash {
    std::size_t operator()(const std::array<std::int64_t, 3>& cell) const {
        std::uint64_t hash = 0;
        for (const std::int64_t c : cell) hash = (hash ^ static_cast<std::uint64_t>(c)) * 0x9e3779b97f4a7c15ULL;
        return hash ^ (hash >> 32U);
    }
};

/// Sets of numbers 0 .. count - 1 that grow together.
class Sets {
public:
    explicit Sets(std::size_t count) : above_(count) { std::iota(above_.begin(), above_.end(), 0); }
    int find(int i) {
        int root = i;
        while (at(root) != root) root = at(root);
        while (at(i) != root) i = std::exchange(at(i), root);
        return root;
    }
    void join(int a, int b) { at(find(a)) = find(b); }

private:
    int& at(int i) { return above_[static_cast<std::size_t>(i)]; }
    std::vector<int> above_;
};

/// The triangles of each group as a mesh of its own.
std::vector<TriangleMesh> split(const TriangleMesh& mesh, const std::vector<int>& group_of_triangle, std::size_t groups) {
    std::vector<TriangleMesh> pieces(groups);
    std::vector<std::vector<std::size_t>> members(groups);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) members[static_cast<std::size_t>(group_of_triangle[t])].push_back(t);
    std::vector<int> place(mesh.corners.size());
    std::vector<int> owner(mesh.corners.size(), -1);
    for (std::size_t g = 0; g < groups; ++g) {
        for (const std::size_t t : members[g]) {
            std::array<int, 3> triangle{};
            for (std::size_t i = 0; i < 3; ++i) {
                const auto corner = static_cast<std::size_t>(mesh.triangles[t][i]);
                if (owner[corner] != static_cast<int>(g)) {
                    owner[corner] = static_cast<int>(g);
                    place[corner] = static_cast<int>(pieces[g].corners.size());
                    pieces[g].corners.push_back(mesh.corners[corner]);
                }
                triangle[i] = place[corner];
            }
            pieces[g].triangles.push_back(triangle);
        }
    }
    return pieces;
}

double volume_of(const Eigen::AlignedBox3d& box) {
    constexpr double margin = 0.005;  // m: plates and sticks have a volume, too
    return (box.sizes().array() + 2 * margin).prod();
}

/// Which pieces go together, so that `most` are left: their numbers, from 0.
std::vector<int> joined(const std::vector<Eigen::AlignedBox3d>& boxes, std::size_t most) {
    constexpr std::size_t looked_at_one_by_one = 300;
    constexpr int cells = 6;  // along each axis
    std::vector<std::size_t> by_size(boxes.size());
    std::iota(by_size.begin(), by_size.end(), 0);
    std::stable_sort(by_size.begin(), by_size.end(), [&](std::size_t a, std::size_t b) { return volume_of(boxes[a]) > volume_of(boxes[b]); });
    Eigen::AlignedBox3d whole;
    for (const auto& box : boxes) whole.extend(box);

    // Thousands of screws: those of one region are one piece from the start.
    struct Group {
        Eigen::AlignedBox3d box;
        std::vector<std::size_t> members;
    };
    std::vector<Group> groups;
    std::map<std::array<int, 3>, std::size_t> regions;
    for (std::size_t rank = 0; rank < by_size.size(); ++rank) {
        const std::size_t piece = by_size[rank];
        std::size_t group = groups.size();
        if (rank >= looked_at_one_by_one) {
            std::array<int, 3> cell{};
            for (int i = 0; i < 3; ++i) {
                const double part = (boxes[piece].center()[i] - whole.min()[i]) / std::max(whole.sizes()[i], 1e-9);
                cell[static_cast<std::size_t>(i)] = std::clamp(static_cast<int>(part * cells), 0, cells - 1);
            }
            group = regions.try_emplace(cell, group).first->second;
        }
        if (group == groups.size()) groups.emplace_back();
        groups[group].box.extend(boxes[piece]);
        groups[group].members.push_back(piece);
    }
    while (groups.size() > most) {
        const auto smallest =
            std::min_element(groups.begin(), groups.end(), [](const Group& a, const Group& b) { return volume_of(a.box) < volume_of(b.box); });
        const Group small = std::move(*smallest);
        groups.erase(smallest);
        const auto growth = [&](const Group& group) { return volume_of(group.box.merged(small.box)) - volume_of(group.box); };
        Group& host = *std::min_element(groups.begin(), groups.end(), [&](const Group& a, const Group& b) { return growth(a) < growth(b); });
        host.box.extend(small.box);
        host.members.insert(host.members.end(), small.members.begin(), small.members.end());
    }
    std::vector<int> group_of(boxes.size());
    for (std::size_t g = 0; g < groups.size(); ++g) {
        for (const std::size_t member : groups[g].members) group_of[member] = static_cast<int>(g);
    }
    return group_of;
}

}  // namespace

TriangleMesh welded(const TriangleMesh& mesh) {
    constexpr double finest = 1e-6;  // of the model's size: a thousand times finer than what a camera sees of it
    const Eigen::AlignedBox3d box = box_of(mesh);
    const double cell = std::max(finest * box.sizes().maxCoeff(), 1e-12);
    TriangleMesh result;
    std::unordered_map<std::array<std::int64_t, 3>, int, CellHash> places;
    places.reserve(mesh.corners.size());
    std::vector<int> place_of(mesh.corners.size());
    for (std::size_t i = 0; i < mesh.corners.size(); ++i) {
        const Eigen::Array3d scaled = (mesh.corners[i] - box.min()).array() / cell;
        const std::array<std::int64_t, 3> key{std::llround(scaled.x()), std::llround(scaled.y()), std::llround(scaled.z())};
        const auto [entry, is_new] = places.try_emplace(key, static_cast<int>(result.corners.size()));
        if (is_new) result.corners.push_back(mesh.corners[i]);
        place_of[i] = entry->second;
    }
    for (const auto& triangle : mesh.triangles) {
        const auto at = [&](std::size_t i) { return place_of[static_cast<std::size_t>(triangle[i])]; };
        if (at(0) != at(1) && at(1) != at(2) && at(2) != at(0)) result.triangles.push_back({at(0), at(1), at(2)});
    }
    return result;
}

std::vector<TriangleMesh> pieces_of(const TriangleMesh& mesh, std::size_t most) {
    Sets sets(mesh.corners.size());
    for (const auto& t : mesh.triangles) {
        sets.join(t[0], t[1]);
        sets.join(t[1], t[2]);
    }
    std::vector<int> number(mesh.corners.size(), -1);
    std::vector<Eigen::AlignedBox3d> boxes;
    std::vector<int> piece_of(mesh.triangles.size());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        int& piece = number[static_cast<std::size_t>(sets.find(mesh.triangles[t][0]))];
        if (piece < 0) {
            piece = static_cast<int>(boxes.size());
            boxes.emplace_back();
        }
        for (std::size_t i = 0; i < 3; ++i) boxes[static_cast<std::size_t>(piece)].extend(mesh.corner(mesh.triangles[t], i));
        piece_of[t] = piece;
    }
    if (boxes.size() <= most) return split(mesh, piece_of, boxes.size());
    const std::vector<int> group = joined(boxes, most);
    for (int& piece : piece_of) piece = group[static_cast<std::size_t>(piece)];
    return split(mesh, piece_of, most);
}

}  // namespace roomfix
