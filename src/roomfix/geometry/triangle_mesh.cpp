#include "roomfix/geometry/triangle_mesh.hpp"

#include <cmath>
#include <map>
#include <numbers>
#include <utility>

namespace roomfix {

void append(TriangleMesh& mesh, const TriangleMesh& other, const Eigen::Affine3d& pose) {
    const int first = static_cast<int>(mesh.corners.size());
    const bool mirrored = pose.linear().determinant() < 0;
    mesh.corners.reserve(mesh.corners.size() + other.corners.size());
    for (const Eigen::Vector3d& p : other.corners) mesh.corners.push_back(pose * p);
    mesh.triangles.reserve(mesh.triangles.size() + other.triangles.size());
    for (const auto& [a, b, c] : other.triangles) mesh.triangles.push_back({first + a, first + (mirrored ? c : b), first + (mirrored ? b : c)});
}

Eigen::AlignedBox3d box_of(const TriangleMesh& mesh) {
    Eigen::AlignedBox3d box;
    for (const auto& triangle : mesh.triangles) {
        for (std::size_t i = 0; i < 3; ++i) box.extend(mesh.corner(triangle, i));
    }
    return box;
}

double enclosed_volume(const TriangleMesh& mesh) {
    if (mesh.corners.empty()) return 0;
    const Eigen::Vector3d origin = mesh.corners.front();
    double six_volumes = 0;
    for (const auto& t : mesh.triangles) six_volumes += (mesh.corner(t, 0) - origin).cross(mesh.corner(t, 1) - origin).dot(mesh.corner(t, 2) - origin);
    return six_volumes / 6;
}

TriangleMesh box_mesh(const Eigen::Vector3d& size) {
    TriangleMesh mesh;
    for (int i = 0; i < 8; ++i) mesh.corners.push_back(0.5 * size.cwiseProduct(Eigen::Vector3d(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1)));
    mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4}, {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
    return mesh;
}

TriangleMesh cylinder_mesh(double radius, double height) {
    constexpr int sides = 16;
    constexpr double pi = std::numbers::pi;
    TriangleMesh mesh;
    const double r = radius / (1 - 0.25 * std::pow(pi / sides, 2));
    for (int i = 0; i < 2 * sides; ++i) {
        const double angle = 2 * pi * (i % sides) / sides;
        mesh.corners.emplace_back(r * std::cos(angle), r * std::sin(angle), i < sides ? -height / 2 : height / 2);
    }
    for (int i = 0; i < sides; ++i) {
        const int next = (i + 1) % sides;
        mesh.triangles.push_back({i, next, sides + next});
        mesh.triangles.push_back({i, sides + next, sides + i});
        if (i == 0 || next == 0) continue;
        mesh.triangles.push_back({0, next, i});
        mesh.triangles.push_back({sides, sides + i, sides + next});
    }
    return mesh;
}

TriangleMesh icosphere(int level) {
    const double g = std::numbers::phi;
    TriangleMesh mesh;
    mesh.corners = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                    {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
    for (Eigen::Vector3d& p : mesh.corners) p.normalize();
    mesh.triangles = {{0, 11, 5}, {0, 5, 1}, {0, 1, 7}, {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                      {3, 9, 4},  {3, 4, 2}, {3, 2, 6}, {3, 6, 8},  {3, 8, 9},   {4, 9, 5}, {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
    for (int i = 0; i < level; ++i) {
        std::map<std::pair<int, int>, int> middles;
        const auto middle = [&](int a, int b) {
            const auto [entry, is_new] = middles.try_emplace(std::minmax(a, b), static_cast<int>(mesh.corners.size()));
            if (is_new) mesh.corners.push_back((mesh.corners[static_cast<std::size_t>(a)] + mesh.corners[static_cast<std::size_t>(b)]).normalized());
            return entry->second;
        };
        std::vector<std::array<int, 3>> finer;
        for (const auto& [a, b, c] : mesh.triangles) {
            const int ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
            finer.insert(finer.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
        }
        mesh.triangles = std::move(finer);
    }
    return mesh;
}

TriangleMesh ball_mesh(double radius) {
    TriangleMesh ball = icosphere(1);
    const double larger = std::cbrt(4.0 / 3 * std::numbers::pi / enclosed_volume(ball));
    for (Eigen::Vector3d& p : ball.corners) p *= larger * radius;
    return ball;
}

}  // namespace roomfix
