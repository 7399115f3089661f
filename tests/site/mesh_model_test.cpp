#include <numbers>

#include "roomfix/geometry/solid_hull.hpp"
#include "roomfix/site/body_parts.hpp"
#include "roomfix/site/mesh_parts.hpp"
#include "roomfix/site/read_mesh.hpp"
#include "roomfix/site/site_text.hpp"
#include "site/model_files.hpp"

namespace roomfix {
namespace {

const Eigen::Vector3d cart_size(0.6, 0.4, 0.3);

Eigen::Vector3d size_of(const SiteRobot& robot) { return 2 * half_size(robot.shape); }

/// An L seen from above: 0.8 x 0.6 m, arms 0.2 m wide, its empty quarter at +x, +y.
TriangleMesh angled_cart() { return prism({{-0.2, -0.1}, {-0.2, 0.5}, {-0.4, 0.5}, {-0.4, -0.3}, {0.4, -0.3}, {0.4, -0.1}}, 0.5); }

TEST_F(ModelFiles, ABoxIsTheSameInEveryFormat) {
    const TriangleMesh box = box_mesh(cart_size);
    TriangleMesh in_cm = box;
    for (auto& p : in_cm.corners) p *= 100;
    TriangleMesh y_up = box;
    for (auto& p : y_up.corners) p = {p.x(), p.z(), -p.y()};
    TriangleMesh y_up_in_cm = y_up;
    for (auto& p : y_up_in_cm.corners) p *= 100;
    write("ascii.stl", ascii_stl(box));
    write("binary.stl", binary_stl(box));
    write("capitals.STL", binary_stl(box));
    write("box.obj", obj(box));
    write("box.ply", ascii_ply(box));
    write("z.dae", dae(in_cm, "Z_UP"));
    write("y.dae", dae(y_up_in_cm, "Y_UP"));
    write("box.gltf", gltf(y_up, "numbers.bin"));
    write("numbers.bin", gltf_bin(y_up));
    for (const char* file : {"ascii.stl", "binary.stl", "capitals.STL", "box.obj", "box.ply", "z.dae", "y.dae", "box.gltf"}) {
        SCOPED_TRACE(file);
        const SiteRobot robot = robot_of(std::string("model: ") + file);
        ASSERT_EQ(robot.parts.size(), 1U);
        EXPECT_EQ(robot.parts[0].points.size(), 8U);
        EXPECT_LT((size_of(robot) - cart_size).norm(), 1e-5) << size_of(robot).transpose();
        EXPECT_NEAR(lowest_point(robot.parts), 0, 1e-9) << "its middle was at the origin: now it stands on the floor";
        EXPECT_NEAR(hull_volume(robot.parts[0].points), cart_size.prod(), 1e-6);
    }
}

TEST_F(ModelFiles, AScaleMakesMetresOfMillimetres) {
    TriangleMesh box = box_mesh(cart_size);
    for (auto& p : box.corners) p *= 1000;
    write("mm.stl", binary_stl(box));
    const SiteRobot robot = robot_of("model: mm.stl, model_scale: 0.001");
    EXPECT_LT((size_of(robot) - cart_size).norm(), 1e-5);
    EXPECT_EQ(robot.model_scale, 0.001);
    const std::string wrong = problem_of("model: mm.stl");
    EXPECT_TRUE(has(wrong, "mm.stl") && has(wrong, "600 x 400 x 300 m") && has(wrong, "model_scale: 0.001")) << wrong;
    EXPECT_TRUE(has(problem_of("model: mm.stl, model_scale: 0.00001"), "model_scale: 0.001"));
}

TEST_F(ModelFiles, ASiteOfAModelIsWrittenAndReadBackTheSame) {
    TriangleMesh cart = angled_cart();
    for (auto& p : cart.corners) p *= 100;
    write("cart.obj", obj(cart));
    const LoadedSite first = site_of("model: cart.obj, model_scale: 0.01");
    const LoadedSite again = parse_site(site_text(first.site), folder);
    ASSERT_TRUE(again.usable()) << site_text(first.site);
    EXPECT_TRUE(has(site_text(first.site), "model: cart.obj, model_scale: 0.01")) << site_text(first.site);
    EXPECT_TRUE(same_parts(first.site.robots[0].parts, again.site.robots[0].parts, 1e-12));
}

TEST_F(ModelFiles, ANotchStaysEmpty) {
    write("cart.obj", obj(angled_cart()));
    const SiteRobot robot = robot_of("model: cart.obj");
    EXPECT_EQ(robot.parts.size(), 2U);
    EXPECT_LT((size_of(robot) - Eigen::Vector3d(0.8, 1.0, 0.5)).norm(), 1e-5) << "twice the farthest from the origin";
    EXPECT_TRUE(inside(robot.parts, {-0.3, 0.45, 0.25}));
    EXPECT_TRUE(inside(robot.parts, {0.35, -0.2, 0.25}));
    EXPECT_FALSE(inside(robot.parts, {-0.17, -0.07, 0.25}));
    double volume = 0;
    for (const ConvexPart& part : robot.parts) volume += hull_volume(part.points);
    EXPECT_NEAR(volume, (0.8 * 0.2 + 0.6 * 0.2) * 0.5, 1e-6);
}

TEST_F(ModelFiles, APolygonWithANotchIsCutUpRight) {
    // The same cart, lying on its back, its L one face of six corners.
    write("cart.obj",
          "v 0 0 0\nv 0.8 0 0\nv 0.8 0 0.2\nv 0.2 0 0.2\nv 0.2 0 0.8\nv 0 0 0.8\nv 0 0.5 0\nv 0.8 0.5 0\nv 0.8 0.5 0.2\nv 0.2 0.5 0.2\nv 0.2 0.5 0.8\nv 0 0.5 "
          "0.8\n"
          "f 1 2 3 4 5 6\nf 12 11 10 9 8 7\nf 1 7 8 2\nf 2 8 9 3\nf 3 9 10 4\nf 4 10 11 5\nf 5 11 12 6\nf 6 12 7 1\n");
    const SiteRobot robot = robot_of("model: cart.obj");
    EXPECT_TRUE(inside(robot.parts, {0.1, 0.25, 0.75}));
    EXPECT_FALSE(inside(robot.parts, {0.25, 0.25, 0.25}));
}

TEST_F(ModelFiles, PiecesApartStayApart) {
    TriangleMesh two = at(box_mesh({0.2, 0.2, 0.2}), {0, 0.3, 0.1});
    append(two, box_mesh({0.2, 0.2, 0.2}), Eigen::Affine3d(Eigen::Translation3d(0, -0.3, 0.1)));
    write("two.stl", binary_stl(two));
    const SiteRobot robot = robot_of("model: two.stl");
    EXPECT_EQ(robot.parts.size(), 2U);
    EXPECT_FALSE(inside(robot.parts, {0, 0, 0.1}));
    EXPECT_TRUE(inside(robot.parts, {0, 0.3, 0.1}));
}

TEST(MeshParts, AFrameIsNotFilled) {
    // Seen from above a square ring, 1 m wide with bars of 0.1 m; no single cut saves anything.
    TriangleMesh ring;
    const auto corner = [](double half, int i) { return Eigen::Vector2d(i == 0 || i == 3 ? -half : half, i < 2 ? -half : half); };
    for (const double z : {0.0, 0.2}) {
        for (const double half : {0.5, 0.4}) {
            for (int i = 0; i < 4; ++i) ring.corners.emplace_back(corner(half, i).x(), corner(half, i).y(), z);
        }
    }
    for (int i = 0; i < 4; ++i) {
        const int j = (i + 1) % 4;
        for (const std::array<int, 4>& q : {std::array{i, j, 8 + j, 8 + i}, std::array{4 + j, 4 + i, 12 + i, 12 + j}, std::array{j, i, 4 + i, 4 + j},
                                            std::array{8 + i, 8 + j, 12 + j, 12 + i}}) {
            ring.triangles.push_back({q[0], q[1], q[2]});
            ring.triangles.push_back({q[0], q[2], q[3]});
        }
    }
    ASSERT_NEAR(enclosed_volume(ring), (1 - 0.64) * 0.2, 1e-9);
    const auto parts = mesh_parts(ring);
    EXPECT_FALSE(inside(parts, {0, 0, 0.1})) << parts.size();
    for (const Eigen::Vector2d& p : {Eigen::Vector2d(0.46, 0.01), {-0.46, 0.31}, {0.23, 0.46}, {0.01, -0.46}}) EXPECT_TRUE(inside(parts, {p.x(), p.y(), 0.1}));
    EXPECT_LE(parts.size(), 8U);
}

TEST(MeshParts, WhatIsConvexIsOnePartWhateverItsShape) {
    EXPECT_EQ(mesh_parts(box_mesh({0.5, 0.4, 0.3})).size(), 1U);
    EXPECT_EQ(mesh_parts(icosphere(4)).size(), 1U);
    const auto cylinder = mesh_parts(cylinder_mesh(0.2, 0.5));
    ASSERT_EQ(cylinder.size(), 1U);
    EXPECT_EQ(cylinder[0].points.size(), 32U) << "the corners of both rims";
    TriangleMesh turned;
    append(turned, box_mesh({0.5, 0.4, 0.3}), Eigen::Affine3d(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized())));
    const auto box = mesh_parts(turned);
    ASSERT_EQ(box.size(), 1U);
    EXPECT_EQ(box[0].points.size(), 8U);
}

TEST(MeshParts, AreFewHoweverManyPiecesThereAre) {
    TriangleMesh mesh = at(box_mesh({1, 1, 0.5}), {0, 0, 0.25});
    for (int i = 0; i < 1000; ++i) {
        const double angle = 0.7 * i, radius = 0.5 * std::sqrt(i / 1000.0);
        append(mesh, box_mesh({0.004, 0.004, 0.02}), Eigen::Affine3d(Eigen::Translation3d(radius * std::cos(angle), radius * std::sin(angle), 0.51)));
    }
    const auto parts = mesh_parts(mesh);
    EXPECT_LE(parts.size(), most_model_parts);
    for (const ConvexPart& part : parts) EXPECT_LE(part.points.size(), most_points_of_part);
    EXPECT_NEAR(box_around(parts).height, 0.52, 0.003);
    EXPECT_TRUE(inside(parts, {0.4, 0.4, 0.1}));
}

TEST_F(ModelFiles, WhatIsNoModelIsRefusedWithItsNameAndTheCure) {
    const TriangleMesh box = box_mesh(cart_size);
    const std::string words = "Dear reader, this is a letter.\nvery sincerely, f 1 2 3\n";
    const std::string picture = std::string("\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\x10\0\0\0\x10", 24) + std::string(300, '\x8f');
    for (const std::string ending : {"stl", "obj", "dae", "ply", "gltf", "glb"}) {
        for (const auto& [kind, bytes] : {std::pair<std::string, std::string>{"words", words}, {"picture", picture}, {"empty", ""}}) {
            const std::string name = kind + "." + ending;
            write(name, bytes);
            const std::string problem = problem_of("model: " + name);
            EXPECT_TRUE(has(problem, name + ": is no " + ending + " file, or a damaged one (") && has(problem, "export the model again")) << problem;
        }
    }
    TriangleMesh y_up = box;
    const std::vector<std::pair<std::string, std::string>> whole = {
        {"a.stl", ascii_stl(box)}, {"b.stl", binary_stl(box)}, {"c.ply", ascii_ply(box)}, {"d.dae", dae(box, "Z_UP")}, {"e.gltf", gltf(y_up, "e.bin")}};
    for (const auto& [name, bytes] : whole) {
        for (const double part : {0.2, 0.6, 0.95}) {
            write(name, bytes.substr(0, static_cast<std::size_t>(part * static_cast<double>(bytes.size()))));
            EXPECT_TRUE(has(problem_of("model: " + name), "damaged")) << name << " " << part;
        }
    }
    write("e.gltf", gltf(y_up, "e.bin"));
    EXPECT_TRUE(has(problem_of("model: e.gltf"), "e.bin")) << problem_of("model: e.gltf");
    write("beyond.obj", "v 0 0 0\nv 1 0 0\nv 0 1 1\nf 1 2 9\n");
    EXPECT_TRUE(has(problem_of("model: beyond.obj"), "damaged")) << problem_of("model: beyond.obj");
    write("points.obj", "v 0 0 0\nv 1 0 0\nv 0 1 1\n");
    EXPECT_TRUE(has(problem_of("model: points.obj"), "no triangles")) << problem_of("model: points.obj");
    write("nan.obj", "v 0 0 0\nv nan 0 0\nv 0 1 1\nf 1 2 3\n");
    EXPECT_TRUE(has(problem_of("model: nan.obj"), "damaged")) << problem_of("model: nan.obj");
    EXPECT_TRUE(has(problem_of("model: none.stl"), "none.stl: there is no such file"));
    write("folder.stl/x", "");
    EXPECT_TRUE(has(problem_of("model: folder.stl"), "is no file"));
    EXPECT_TRUE(has(problem_of("model: cart.step"), "'cart.step' is no model"));
    EXPECT_TRUE(has(problem_of("model: cart.xacro"), "xacro"));
}

TEST_F(ModelFiles, FilesThatMakeTheReaderHangOrCrashAreRefusedInTime) {
    // Assimp 5.2.5 never comes back from letters among a COLLADA's indices.
    std::string hangs = dae(box_mesh(cart_size), "Z_UP");
    hangs.replace(hangs.find("<p>") + 3, 1, "J");
    write("hangs.dae", hangs);
    EXPECT_TRUE(has(problem_of("model: hangs.dae"), "damaged")) << problem_of("model: hangs.dae");
}

TEST_F(ModelFiles, SizesThatNoRobotHasAreRefused) {
    const auto problem = [&](const TriangleMesh& mesh) {
        write("cart.obj", obj(mesh));
        return problem_of("model: cart.obj");
    };
    EXPECT_TRUE(has(problem(box_mesh({11, 1, 1})), "11 x 1 x 1 m")) << problem(box_mesh({11, 1, 1}));
    EXPECT_TRUE(has(problem(box_mesh({30, 20, 20})), "centimetres: model_scale: 0.01")) << problem(box_mesh({30, 20, 20}));
    EXPECT_TRUE(has(problem(box_mesh({0.015, 0.012, 0.012})), "model_scale"));
    EXPECT_TRUE(has(problem(box_mesh({1, 1, 0.001})), "flat"));
    EXPECT_TRUE(has(problem(at(box_mesh({1, 1, 1}), {3, 4, 0})), "5.00 m away from its origin"));
}

TEST_F(ModelFiles, AScaleBelongsToAMesh) {
    const auto only = [&](const std::string& keys) {
        const LoadedSite loaded = site_of(keys);
        return loaded.problems.empty() ? std::string("nothing is wrong") : loaded.problems[0].message;
    };
    write("a.urdf", "<robot name='a'/>");
    EXPECT_TRUE(has(only("model: a.urdf, model_scale: 2"), "a URDF is in metres"));
    EXPECT_TRUE(has(only("model: a.body, model_scale: 2"), "a body file is in metres"));
    EXPECT_TRUE(has(only("shape: box, size: [1, 1, 1], model_scale: 2"), "there is none"));
    write("box.obj", obj(box_mesh(cart_size)));
    EXPECT_TRUE(has(only("model: box.obj, model_scale: 0"), "must lie between"));
}

}  // namespace
}  // namespace roomfix
