// Model files that tests write, and the bodies that sites make of them.
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "roomfix/geometry/triangle_mesh.hpp"
#include "roomfix/site/load_site.hpp"

namespace roomfix {

/// A folder of its own for each test.
class ModelFiles : public ::testing::Test {
protected:
    void SetUp() override {
        folder = std::filesystem::temp_directory_path() / (std::string("roomfix-model-") + ::testing::UnitTest::GetInstance()->current_test_info()->name());
        std::filesystem::remove_all(folder);
        std::filesystem::create_directories(folder);
    }
    void TearDown() override { std::filesystem::remove_all(folder); }

    void write(const std::string& name, const std::string& bytes) const {
        std::filesystem::create_directories((folder / name).parent_path());
        std::ofstream(folder / name, std::ios::binary) << bytes;
    }
    /// A site whose only robot has these keys, on line 4 from column 9.
    LoadedSite site_of(const std::string& keys) const { return parse_site("roomfix: 1\nsite: {name: lab}\nrobots:\n  cart: {" + keys + "}\n", folder); }
    /// The robot; none, and a failure, where there are problems.
    SiteRobot robot_of(const std::string& keys) const {
        LoadedSite loaded = site_of(keys);
        for (const Problem& p : loaded.problems) ADD_FAILURE() << problem_text("site", p);
        return loaded.usable() ? loaded.site.robots.at(0) : SiteRobot();
    }
    /// What is wrong with a site of this robot; it has to be said at the value of `model`, the first key.
    std::string problem_of(const std::string& keys) const {
        const LoadedSite loaded = site_of(keys);
        if (loaded.usable()) return "nothing is wrong";
        EXPECT_EQ(loaded.problems.size(), 1U) << keys;
        EXPECT_EQ(loaded.problems[0].line, 4) << keys;
        EXPECT_EQ(loaded.problems[0].column, 17) << keys;
        return loaded.problems[0].message;
    }

    std::filesystem::path folder;
};

inline bool has(const std::string& text, const std::string& words) { return text.find(words) != std::string::npos; }

inline std::string ascii_stl(const TriangleMesh& mesh) {
    std::string text = "solid thing\n";
    for (const auto& t : mesh.triangles) {
        text += " facet normal 0 0 0\n  outer loop\n";
        for (std::size_t i = 0; i < 3; ++i) {
            const Eigen::Vector3d& p = mesh.corner(t, i);
            text += "   vertex " + std::to_string(p.x()) + " " + std::to_string(p.y()) + " " + std::to_string(p.z()) + "\n";
        }
        text += "  endloop\n endfacet\n";
    }
    return text + "endsolid thing\n";
}

template <class T>
void put_bytes(std::string& bytes, const T& value) {
    std::array<char, sizeof(T)> raw;
    std::memcpy(raw.data(), &value, sizeof value);
    bytes.append(raw.data(), raw.size());
}

inline std::string binary_stl(const TriangleMesh& mesh) {
    std::string bytes = "a binary STL";
    bytes.resize(80, ' ');
    put_bytes(bytes, static_cast<std::uint32_t>(mesh.triangles.size()));
    for (const auto& t : mesh.triangles) {
        for (int i = 0; i < 3; ++i) put_bytes(bytes, 0.0f);
        for (std::size_t i = 0; i < 3; ++i) {
            for (const double v : mesh.corner(t, i)) put_bytes(bytes, static_cast<float>(v));
        }
        put_bytes(bytes, std::uint16_t{0});
    }
    return bytes;
}

inline std::string obj(const TriangleMesh& mesh) {
    std::string text = "mtllib none.mtl\no thing\n";
    for (const auto& p : mesh.corners) text += "v " + std::to_string(p.x()) + " " + std::to_string(p.y()) + " " + std::to_string(p.z()) + "\n";
    for (const auto& t : mesh.triangles) text += "f " + std::to_string(t[0] + 1) + " " + std::to_string(t[1] + 1) + " " + std::to_string(t[2] + 1) + "\n";
    return text;
}

inline std::string ascii_ply(const TriangleMesh& mesh) {
    std::string text = "ply\nformat ascii 1.0\nelement vertex " + std::to_string(mesh.corners.size()) +
                       "\nproperty float x\nproperty float y\nproperty float z\nelement face " + std::to_string(mesh.triangles.size()) +
                       "\nproperty list uchar int vertex_indices\nend_header\n";
    for (const auto& p : mesh.corners) text += std::to_string(p.x()) + " " + std::to_string(p.y()) + " " + std::to_string(p.z()) + "\n";
    for (const auto& t : mesh.triangles) text += "3 " + std::to_string(t[0]) + " " + std::to_string(t[1]) + " " + std::to_string(t[2]) + "\n";
    return text;
}

/// `up`: X_UP, Y_UP or Z_UP; in centimetres.
inline std::string dae(const TriangleMesh& mesh, const std::string& up) {
    std::string places, indices;
    for (const auto& p : mesh.corners) places += std::to_string(p.x()) + " " + std::to_string(p.y()) + " " + std::to_string(p.z()) + " ";
    for (const auto& t : mesh.triangles) indices += std::to_string(t[0]) + " " + std::to_string(t[1]) + " " + std::to_string(t[2]) + " ";
    return R"(<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="cm" meter="0.01"/><up_axis>)" +
           up + R"(</up_axis></asset><library_geometries><geometry id="g"><mesh><source id="p"><float_array id="a" count=")" +
           std::to_string(3 * mesh.corners.size()) + "\">" + places + R"(</float_array><technique_common><accessor source="#a" count=")" +
           std::to_string(mesh.corners.size()) +
           R"(" stride="3"><param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices><triangles count=")" +
           std::to_string(mesh.triangles.size()) + R"("><input semantic="VERTEX" source="#v" offset="0"/><p>)" + indices +
           R"(</p></triangles></mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node><instance_geometry url="#g"/></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>)";
}

/// The text of a glTF whose numbers stand in `bin`.
inline std::string gltf(const TriangleMesh& mesh, const std::string& bin) {
    const auto count = std::to_string(mesh.corners.size());
    const auto places = std::to_string(12 * mesh.corners.size()), indices = std::to_string(6 * mesh.triangles.size());
    const Eigen::AlignedBox3d box = box_of(mesh);
    const auto list = [](const Eigen::Vector3d& p) { return "[" + std::to_string(p.x()) + "," + std::to_string(p.y()) + "," + std::to_string(p.z()) + "]"; };
    return R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],)"
           R"("buffers":[{"uri":")" +
           bin + R"(","byteLength":)" + std::to_string(12 * mesh.corners.size() + 6 * mesh.triangles.size()) +
           R"(}],"bufferViews":[{"buffer":0,"byteLength":)" + places + R"(},{"buffer":0,"byteOffset":)" + places + R"(,"byteLength":)" + indices +
           R"(}],"accessors":[{"bufferView":0,"componentType":5126,"count":)" + count + R"(,"type":"VEC3","min":)" + list(box.min()) + R"(,"max":)" +
           list(box.max()) + R"(},{"bufferView":1,"componentType":5123,"count":)" + std::to_string(3 * mesh.triangles.size()) + R"(,"type":"SCALAR"}]})";
}

inline std::string gltf_bin(const TriangleMesh& mesh) {
    std::string bytes;
    for (const auto& p : mesh.corners) {
        for (const double v : p) put_bytes(bytes, static_cast<float>(v));
    }
    for (const auto& t : mesh.triangles) {
        for (const int i : t) put_bytes(bytes, static_cast<std::uint16_t>(i));
    }
    return bytes;
}

/// Is a point inside one of the parts, as far as 2562 directions tell?
inline bool inside(const std::vector<ConvexPart>& parts, const Eigen::Vector3d& point) {
    for (const ConvexPart& part : parts) {
        bool separated = false;
        for (const Eigen::Vector3d& direction : icosphere(4).corners) {
            double reach = -1e9;
            for (const Eigen::Vector3d& p : part.points) reach = std::max(reach, direction.dot(p));
            if (direction.dot(point) > reach) separated = true;
        }
        if (!separated) return true;
    }
    return false;
}

/// A solid at a place.
inline TriangleMesh at(const TriangleMesh& mesh, const Eigen::Vector3d& place) {
    TriangleMesh moved;
    append(moved, mesh, Eigen::Affine3d(Eigen::Translation3d(place)));
    return moved;
}

/// An upright prism over a polygon that turns left, cut up from its first corner: which must see all others.
inline TriangleMesh prism(const std::vector<Eigen::Vector2d>& polygon, double height) {
    TriangleMesh mesh;
    const int n = static_cast<int>(polygon.size());
    for (const double z : {0.0, height}) {
        for (const auto& p : polygon) mesh.corners.emplace_back(p.x(), p.y(), z);
    }
    for (int i = 0; i < n; ++i) {
        const int next = (i + 1) % n;
        mesh.triangles.push_back({i, next, n + next});
        mesh.triangles.push_back({i, n + next, n + i});
        if (i == 0 || next == 0) continue;
        mesh.triangles.push_back({0, next, i});
        mesh.triangles.push_back({n, n + i, n + next});
    }
    return mesh;
}

}  // namespace roomfix
