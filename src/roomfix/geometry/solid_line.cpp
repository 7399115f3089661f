#include "roomfix/geometry/solid_line.hpp"

#include <algorithm>
#include <array>

namespace roomfix {

SolidLine::SolidLine(const TriangleMesh& mesh, int axis, const Eigen::Vector3d& at) {
    const int u = (axis + 1) % 3;
    const int v = (axis + 2) % 3;
    int sum = 0;
    for (const auto& t : mesh.triangles) {
        const std::array<const Eigen::Vector3d*, 3> p = {&mesh.corner(t, 0), &mesh.corner(t, 1), &mesh.corner(t, 2)};
        // Twice the areas that the line's point makes with the sides, seen along the axis: all of one sign inside.
        std::array<double, 3> area{};
        for (std::size_t i = 0; i < 3; ++i) {
            const Eigen::Vector3d& a = *p[(i + 1) % 3];
            const Eigen::Vector3d& b = *p[(i + 2) % 3];
            area[i] = (a[u] - at[u]) * (b[v] - at[v]) - (a[v] - at[v]) * (b[u] - at[u]);
        }
        const bool faces_up = area[0] > 0 && area[1] > 0 && area[2] > 0;
        const bool faces_down = area[0] < 0 && area[1] < 0 && area[2] < 0;
        if (!faces_up && !faces_down) continue;
        const double place = (area[0] * (*p[0])[axis] + area[1] * (*p[1])[axis] + area[2] * (*p[2])[axis]) / (area[0] + area[1] + area[2]);
        crossings_.emplace_back(place, faces_down ? 1 : -1);
        sum += crossings_.back().second;
    }
    closed_ = sum == 0;
}

bool SolidLine::inside(double place) const {
    if (!closed_) return false;
    int layers = 0;
    for (const auto& [crossing, step] : crossings_) layers += crossing < place ? step : 0;
    return layers != 0;
}

}  // namespace roomfix
