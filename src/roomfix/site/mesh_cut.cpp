#include "roomfix/site/mesh_cut.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "roomfix/geometry/solid_hull.hpp"
#include "roomfix/geometry/solid_line.hpp"

namespace roomfix {
namespace {

constexpr int cuts = 15;               // tried along each axis
constexpr double in_plane = 1e-6;      // of the extent: nearer than that lies in a plane
constexpr double thinnest = 0.01;      // m: thinner pieces are not cut
constexpr double touching_end = 0.01;  // of the extent: no cut so near to an end

bool faces_up(const TriangleMesh& mesh, const std::array<int, 3>& t, int axis) {
    return (mesh.corner(t, 1) - mesh.corner(t, 0)).cross(mesh.corner(t, 2) - mesh.corner(t, 0))[axis] > 0;
}

/// Where to cut along an axis: evenly spread, each moved onto the largest face across the axis that is nearer to it than to the others.
std::vector<double> places_along(const TriangleMesh& mesh, int axis, double low, double high) {
    const double step = (high - low) / (cuts + 1);
    std::array<double, cuts + 1> place{};
    std::array<double, cuts + 1> largest{};
    for (int k = 1; k <= cuts; ++k) place[static_cast<std::size_t>(k)] = low + k * step;
    for (const auto& t : mesh.triangles) {
        const double a = mesh.corner(t, 0)[axis];
        const auto nearest = static_cast<std::size_t>(std::clamp<long>(std::lround((a - low) / step), 1, cuts));
        if (std::min(a - low, high - a) < touching_end * (high - low)) continue;
        if (std::max(std::abs(mesh.corner(t, 1)[axis] - a), std::abs(mesh.corner(t, 2)[axis] - a)) > in_plane * (high - low)) continue;
        const double area = (mesh.corner(t, 1) - mesh.corner(t, 0)).cross(mesh.corner(t, 2) - mesh.corner(t, 0)).norm();
        if (area <= largest[nearest]) continue;
        largest[nearest] = area;
        place[nearest] = a;
    }
    return {place.begin() + 1, place.end()};
}

/// The edges along an axis of the box that earlier cuts made, and where they run inside the solid: two such cuts across meet there.
class InnerEdges {
public:
    InnerEdges(const Chunk& chunk, int axis) : axis_(axis), shift_(1e-4 * box_of(*chunk.whole).sizes().maxCoeff()) {
        for (int i = 0; i < 4; ++i) {
            Eigen::Vector3d edge = Eigen::Vector3d::Zero(), within = Eigen::Vector3d::Zero();
            for (int k = 0; k < 2; ++k) {
                const int across = (axis + 1 + k) % 3;
                const bool upper = (i >> k) & 1;
                edge[across] = upper ? chunk.limits.max()[across] : chunk.limits.min()[across];
                within[across] = edge[across] + (upper ? -shift_ : shift_);  // cuts lie on faces: look a little inside
            }
            if (edge.allFinite()) edges_.emplace_back(edge, SolidLine(*chunk.whole, axis, within));
        }
    }

    /// Calls take(point) for those that are inside just below the place, or just above it (m along the axis).
    template <class Take>
    void each_inside(double place, bool above, const Take& take) const {
        for (const auto& [edge, line] : edges_) {
            if (!line.inside(place + (above ? shift_ : -shift_))) continue;
            Eigen::Vector3d point = edge;
            point[axis_] = place;
            take(point);
        }
    }

private:
    int axis_;
    double shift_;  // m
    std::vector<std::pair<Eigen::Vector3d, SolidLine>> edges_;
};

/// The farthest points of the slabs that parallel planes make of a mesh, from below and from above each plane.
class Slabs {
public:
    Slabs(const Chunk& chunk, int axis, const std::vector<double>& places, double exact)
        : mesh_(chunk.surface),
          axis_(axis),
          places_(places),
          exact_(exact),
          slabs_(places.size() + 1, Supports(Supports::Directions::few)),
          added_(mesh_.corners.size()) {
        for (const auto& t : mesh_.triangles) add(t);
        for (const Eigen::Vector3d& p : chunk.inner) slabs_[static_cast<std::size_t>(planes_below(p[axis]))].add(p);
        const InnerEdges edges(chunk, axis);
        for (std::size_t k = 0; k < places.size(); ++k) {
            edges.each_inside(places[k], false, [&](const Eigen::Vector3d& p) { slabs_[k].add(p); });
            edges.each_inside(places[k], true, [&](const Eigen::Vector3d& p) { slabs_[k + 1].add(p); });
        }
    }

    /// Volume of the two hulls on both sides of each plane (m^3).
    std::vector<double> volumes() const {
        std::vector<double> sum(places_.size());
        Supports below(Supports::Directions::few);
        Supports above(Supports::Directions::few);
        for (std::size_t k = 0; k < places_.size(); ++k) {
            below.add(slabs_[k]);
            above.add(slabs_[places_.size() - k]);
            sum[k] += below.volume();
            sum[places_.size() - 1 - k] += above.volume();
        }
        return sum;
    }

private:
    int planes_below(double value) const { return static_cast<int>(std::upper_bound(places_.begin(), places_.end(), value) - places_.begin()); }

    void add(const std::array<int, 3>& t) {
        std::array<double, 3> at{};
        for (std::size_t i = 0; i < 3; ++i) at[i] = mesh_.corner(t, i)[axis_];
        const auto [low, high] = std::minmax({at[0], at[1], at[2]});
        int first = planes_below(low + exact_);
        int last = planes_below(high - exact_);
        if (first > last) {  // it lies in a plane: its solid is on the side that it does not face
            first = last = faces_up(mesh_, t, axis_) ? last : first;
        }
        for (std::size_t i = 0; i < 3; ++i) add_corner(t[i], std::clamp(planes_below(at[i]), first, last));
        for (int k = first; k < last; ++k) {
            for (std::size_t i = 0; i < 3; ++i) add_crossing(mesh_.corner(t, i), mesh_.corner(t, (i + 1) % 3), k);
        }
    }

    /// Once for each of the two slabs that a corner in a plane may belong to.
    void add_corner(int corner, int slab) {
        const auto i = static_cast<std::size_t>(corner);
        const auto mark = static_cast<unsigned char>(1U << (static_cast<unsigned>(slab) & 1U));
        if (added_[i] & mark) return;
        added_[i] |= mark;
        slabs_[static_cast<std::size_t>(slab)].add(mesh_.corners[i]);
    }

    void add_crossing(const Eigen::Vector3d& p, const Eigen::Vector3d& q, int plane) {
        const double from = p[axis_] - places_[static_cast<std::size_t>(plane)];
        const double to = q[axis_] - places_[static_cast<std::size_t>(plane)];
        if (from * to > 0 || from == to) return;
        const Eigen::Vector3d point = p + from / (from - to) * (q - p);
        slabs_[static_cast<std::size_t>(plane)].add(point);
        slabs_[static_cast<std::size_t>(plane) + 1].add(point);
    }

    const TriangleMesh& mesh_;
    int axis_;
    const std::vector<double>& places_;
    double exact_;
    std::vector<Supports> slabs_;
    std::vector<unsigned char> added_;
};

/// One side of a cut, corner by corner.
class Side {
public:
    explicit Side(const TriangleMesh& whole) : whole_(whole), place_(whole.corners.size(), -1) {}

    int corner(int index) {
        int& place = place_[static_cast<std::size_t>(index)];
        if (place < 0) place = add(whole_.corners[static_cast<std::size_t>(index)]);
        return place;
    }
    int add(const Eigen::Vector3d& point) {
        mesh.corners.push_back(point);
        return static_cast<int>(mesh.corners.size()) - 1;
    }

    TriangleMesh mesh;

private:
    const TriangleMesh& whole_;
    std::vector<int> place_;
};

/// The part of a triangle on one side; `beyond` of its corners is positive there (m).
void add_part(Side& side, const TriangleMesh& mesh, const std::array<int, 3>& t, const std::array<double, 3>& beyond) {
    std::array<int, 4> polygon{};
    std::size_t count = 0;
    for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t next = (i + 1) % 3;
        if (beyond[i] >= 0) polygon[count++] = side.corner(t[i]);
        if ((beyond[i] > 0 && beyond[next] < 0) || (beyond[i] < 0 && beyond[next] > 0)) {
            polygon[count++] = side.add(mesh.corner(t, i) + beyond[i] / (beyond[i] - beyond[next]) * (mesh.corner(t, next) - mesh.corner(t, i)));
        }
    }
    for (std::size_t i = 2; i < count; ++i) side.mesh.triangles.push_back({polygon[0], polygon[i - 1], polygon[i]});
}

}  // namespace

Chunk chunk_of(TriangleMesh mesh) {
    Chunk chunk;
    chunk.whole = std::make_shared<const TriangleMesh>(mesh);
    chunk.surface = std::move(mesh);
    return chunk;
}

double hull_volume(const Chunk& chunk) {
    Supports supports(Supports::Directions::few);
    for (const Eigen::Vector3d& p : chunk.surface.corners) supports.add(p);
    for (const Eigen::Vector3d& p : chunk.inner) supports.add(p);
    return supports.volume();
}

Cut best_cut(const Chunk& chunk) {
    Cut best;
    const Eigen::AlignedBox3d box = box_of(chunk.surface);
    const double whole = hull_volume(chunk);
    for (int axis = 0; axis < 3 && !box.isEmpty(); ++axis) {
        const double low = box.min()[axis], high = box.max()[axis];
        if (high - low < thinnest) continue;
        const std::vector<double> places = places_along(chunk.surface, axis, low, high);
        const std::vector<double> volumes = Slabs(chunk, axis, places, in_plane * (high - low)).volumes();
        for (std::size_t k = 0; k < places.size(); ++k) {
            if (whole - volumes[k] > best.saving) best = {axis, places[k], whole - volumes[k]};
        }
    }
    return best;
}

std::pair<Chunk, Chunk> cut_apart(const Chunk& chunk, const Cut& cut) {
    const TriangleMesh& mesh = chunk.surface;
    Side below(mesh), above(mesh);
    const double exact = in_plane * box_of(mesh).sizes()[cut.axis];
    for (const auto& t : mesh.triangles) {
        std::array<double, 3> beyond{};
        for (std::size_t i = 0; i < 3; ++i) {
            beyond[i] = mesh.corner(t, i)[cut.axis] - cut.place;
            if (std::abs(beyond[i]) <= exact) beyond[i] = 0;
        }
        const auto [low, high] = std::minmax({beyond[0], beyond[1], beyond[2]});
        if (low == 0 && high == 0) {
            add_part(faces_up(mesh, t, cut.axis) ? below : above, mesh, t, beyond);
            continue;
        }
        if (high > 0) add_part(above, mesh, t, beyond);
        if (low < 0) add_part(below, mesh, t, {-beyond[0], -beyond[1], -beyond[2]});
    }
    std::pair<Chunk, Chunk> sides{{chunk.whole, std::move(below.mesh), {}, chunk.limits}, {chunk.whole, std::move(above.mesh), {}, chunk.limits}};
    sides.first.limits.max()[cut.axis] = sides.second.limits.min()[cut.axis] = cut.place;
    for (const Eigen::Vector3d& p : chunk.inner) (p[cut.axis] < cut.place ? sides.first : sides.second).inner.push_back(p);
    const InnerEdges edges(chunk, cut.axis);
    edges.each_inside(cut.place, false, [&](const Eigen::Vector3d& p) { sides.first.inner.push_back(p); });
    edges.each_inside(cut.place, true, [&](const Eigen::Vector3d& p) { sides.second.inner.push_back(p); });
    return sides;
}

}  // namespace roomfix
