// Any bytes as a mesh: the first says in which format, or that the others are corners of triangles. An error, or parts.
#include <algorithm>
#include <array>
#include <cstring>
#include <string>

#include "roomfix/overhead/body.hpp"
#include "roomfix/site/mesh_parts.hpp"
#include "roomfix/site/read_mesh.hpp"

namespace {

/// Three signed bytes a corner, within 1.28 m: many corners coincide, lie in planes and on edges.
roomfix::TriangleMesh soup(const unsigned char* data, std::size_t size) {
    roomfix::TriangleMesh mesh;
    for (std::size_t i = 0; i + 3 <= size; i += 3) {
        const auto at = [&](std::size_t k) { return 0.01 * static_cast<signed char>(data[i + k]); };
        mesh.corners.emplace_back(at(0), at(1), at(2));
    }
    for (int i = 0; i + 3 <= static_cast<int>(mesh.corners.size()); i += 3) mesh.triangles.push_back({i, i + 1, i + 2});
    return mesh;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
    if (size == 0) return 0;
    constexpr std::array endings = {"stl", "obj", "dae", "ply", "gltf", "glb"};
    const std::size_t format = data[0] % (2 * endings.size());  // half of them corners: they are quick
    roomfix::SiteRobot robot;
    if (format >= endings.size()) {
        robot.parts = roomfix::mesh_parts(soup(data + 1, std::min<std::size_t>(size - 1, 9000)));
    } else {
        const std::string bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
        const auto mesh = roomfix::parse_mesh(bytes, std::string("/nowhere/fuzz.") + endings[format], roomfix::UpAxis::as_stated);
        if (!mesh || roomfix::box_of(*mesh).sizes().maxCoeff() > 10) return 0;
        robot.parts = roomfix::mesh_parts(*mesh);
    }
    (void)roomfix::body_of(robot);
    return 0;
}
