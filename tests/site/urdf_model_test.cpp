#include <numbers>

#include "roomfix/site/body_parts.hpp"
#include "roomfix/site/read_urdf.hpp"
#include "site/model_files.hpp"

namespace roomfix {
namespace {

std::string visual(const std::string& solid, const std::string& origin = "") {
    return "<visual>" + (origin.empty() ? "" : "<origin " + origin + "/>") + "<geometry>" + solid + "</geometry></visual>";
}
std::string link(const std::string& name, const std::string& inside = "") { return "<link name='" + name + "'>" + inside + "</link>\n"; }
std::string joint(const std::string& parent, const std::string& child, const std::string& origin, const std::string& type = "fixed") {
    return "<joint name='" + child + "_joint' type='" + type + "'><parent link='" + parent + "'/><child link='" + child + "'/><origin " + origin +
           "/></joint>\n";
}
std::string robot(const std::string& inside) { return "<?xml version='1.0'?>\n<robot name='cart'>\n" + inside + "</robot>\n"; }

const std::string body = link("base_link", visual("<box size='0.5 0.3 0.2'/>"));
const std::string wheel = visual("<cylinder radius='0.1' length='0.04'/>");
const std::string wheels = link("left", wheel) + link("right", wheel) +
                           joint("base_link", "left", "xyz='0.1 0.2 -0.05' rpy='1.5707963267948966 0 0'", "continuous") +
                           joint("base_link", "right", "xyz='0.1 -0.2 -0.05' rpy='1.5707963267948966 0 0'", "continuous");

Eigen::AlignedBox3d box_of_parts(const std::vector<ConvexPart>& parts) {
    Eigen::AlignedBox3d box;
    for (const ConvexPart& part : parts) {
        for (const auto& p : part.points) box.extend(p);
    }
    return box;
}

TEST_F(ModelFiles, AUrdfStandsOnItsWheels) {
    write("cart.urdf", robot(body + wheels));
    const SiteRobot cart = robot_of("model: cart.urdf");
    ASSERT_EQ(cart.parts.size(), 3U);
    const Eigen::AlignedBox3d box = box_of_parts(cart.parts);
    EXPECT_NEAR(box.min().z(), 0, 1e-9);
    EXPECT_NEAR(box.max().z(), 0.25, 0.002) << "from the wheels' lower edge, 0.15 m below base_link, to the box's upper one, 0.1 m above it";
    EXPECT_NEAR(box.max().y(), 0.22, 1e-6) << "wheels are turned by their joints";
    EXPECT_NEAR(box.min().x(), -0.25, 1e-6);
    EXPECT_TRUE(inside(cart.parts, {0.1, 0.2, 0.01}));
    EXPECT_FALSE(inside(cart.parts, {0.1, 0, 0.01})) << "nothing between the wheels";
    EXPECT_NEAR(std::get<Box>(cart.shape).width, 0.44, 1e-6);
}

TEST_F(ModelFiles, TheOriginIsTheBaseWhereverTheRootIs) {
    // base_link hangs below a root that is 1 m away and turned by a quarter.
    write("cart.urdf", robot(link("world_ish") + joint("world_ish", "base_link", "xyz='1 0 3' rpy='0 0 1.5707963267948966'") + body + wheels));
    const Eigen::AlignedBox3d box = box_of_parts(robot_of("model: cart.urdf").parts);
    EXPECT_NEAR(box.max().x(), 0.25, 1e-6);
    EXPECT_NEAR(box.max().y(), 0.22, 1e-6);
    EXPECT_NEAR(box.min().z(), 0, 1e-9);
}

TEST_F(ModelFiles, AFootprintSaysWhereTheFloorIs) {
    const auto cart = [&](const std::string& height) {
        return robot(link("base_footprint") + joint("base_footprint", "base_link", "xyz='0 0 " + height + "'") + body + wheels);
    };
    write("right.urdf", cart("0.15"));
    EXPECT_NEAR(box_of_parts(robot_of("model: right.urdf").parts).max().z(), 0.25, 0.002);
    write("near.urdf", cart("0.18"));
    EXPECT_NEAR(box_of_parts(robot_of("model: near.urdf").parts).min().z(), 0.03, 0.002) << "3 cm above the floor it stays";
    write("high.urdf", cart("0.35"));
    const std::string high = problem_of("model: high.urdf");
    EXPECT_TRUE(has(high, "high.urdf") && has(high, "0.20 m above the floor") && has(high, "lower everything")) << high;
    write("low.urdf", cart("0.05"));
    EXPECT_TRUE(has(problem_of("model: low.urdf"), "0.10 m below the floor")) << problem_of("model: low.urdf");
}

TEST(Urdf, JointsAndOriginsTurnAboutFixedAxes) {
    // An arm of 0.4 m along the link's x, turned up by the joint (-90 deg about y), then by 90 deg about z.
    const std::string text = robot(link("base") + link("arm", visual("<box size='0.4 0.02 0.1'/>", "xyz='0.2 0 0'")) +
                                   joint("base", "arm", "xyz='0 0 0.1' rpy='0 -1.5707963267948966 1.5707963267948966'", "revolute"));
    const auto model = parse_urdf(text, "arm.urdf");
    ASSERT_TRUE(model) << model.error().message;
    EXPECT_EQ(model->origin, "base");
    const Eigen::AlignedBox3d box = box_of(model->mesh);
    EXPECT_LT((box.min() - Eigen::Vector3d(-0.01, -0.05, 0.1)).norm(), 1e-9) << box.min().transpose();
    EXPECT_LT((box.max() - Eigen::Vector3d(0.01, 0.05, 0.5)).norm(), 1e-9) << box.max().transpose();
}

TEST(Urdf, WhatCollidesCountsOnlyWhereNothingIsVisible) {
    const auto collision = [](const std::string& size) { return "<collision><geometry><box size='" + size + "'/></geometry></collision>"; };
    const auto model = parse_urdf(
        robot(link("a", visual("<box size='0.2 0.2 0.2'/>") + collision("1 1 1")) + link("b", collision("0.1 0.1 0.1")) + joint("a", "b", "xyz='0 0 0.15'")),
        "cart.urdf");
    ASSERT_TRUE(model) << model.error().message;
    EXPECT_LT((box_of(model->mesh).sizes() - Eigen::Vector3d(0.2, 0.2, 0.3)).norm(), 1e-9);
}

TEST(Urdf, ASphereHasItsVolume) {
    const auto model = parse_urdf(robot(link("a", visual("<sphere radius='0.3'/>"))), "ball.urdf");
    ASSERT_TRUE(model) << model.error().message;
    EXPECT_NEAR(enclosed_volume(model->mesh), 4.0 / 3 * std::numbers::pi * 0.027, 1e-9);
}

TEST_F(ModelFiles, MeshesAreFoundInPackagesAndBesideTheUrdf) {
    TriangleMesh mm = box_mesh({400, 200, 100});
    write("ws/src/cart_description/meshes/base.stl", binary_stl(mm));
    write("ws/src/cart_description/urdf/near.obj", obj(box_mesh({0.1, 0.1, 0.1})));
    TriangleMesh on_side = box_mesh({10, 20, 30});
    write("ws/src/wheels/lib/side.dae", dae(on_side, "Y_UP"));
    const std::string scaled = "<mesh filename='package://cart_description/meshes/base.stl' scale='0.001 0.001 -0.001'/>";
    write("ws/src/cart_description/urdf/cart.urdf",
          robot(link("base_link", visual(scaled, "xyz='0 0 0.05'") + visual("<mesh filename='near.obj'/>", "xyz='0 0 0.15'")) +
                link("third", visual("<mesh filename='package://wheels/lib/side.dae'/>", "xyz='0 0 0.35'")) + joint("base_link", "third", "xyz='0 0 0'")));
    const SiteRobot cart = robot_of("model: ws/src/cart_description/urdf/cart.urdf");
    EXPECT_EQ(cart.parts.size(), 3U);
    const Eigen::AlignedBox3d box = box_of_parts(cart.parts);
    EXPECT_NEAR(box.sizes().x(), 0.4, 1e-6);
    EXPECT_NEAR(box.sizes().z(), 0.5, 1e-6) << "the axis that a COLLADA calls up is ignored in a URDF";
}

TEST_F(ModelFiles, AMeshThatIsMissingIsNamedWithThePlacesLookedAt) {
    const auto cart = [&](const std::string& filename) {
        write("a/cart.urdf", robot(link("base", visual("<mesh filename='" + filename + "'/>"))));
        return problem_of("model: a/cart.urdf");
    };
    const std::string missing = cart("package://spot_description/meshes/base.dae");
    EXPECT_TRUE(has(missing, "cart.urdf:3") && has(missing, "meshes/base.dae") && has(missing, "'spot_description'")) << missing;
    EXPECT_TRUE(has(cart("base.stl"), (folder / "a/base.stl").string())) << cart("base.stl");
    EXPECT_TRUE(has(cart("http://example.org/base.stl"), "no file on this computer"));
    EXPECT_TRUE(has(cart("package://../../etc/passwd"), "names no package"));
    EXPECT_TRUE(has(cart("cart.urdf"), "is no mesh"));
    write("a/bad.stl", "nothing");
    EXPECT_TRUE(has(cart("bad.stl"), "bad.stl: is no stl file")) << cart("bad.stl");
}

TEST(Urdf, WhatIsNoUrdfIsRefusedWithTheLine) {
    const struct {
        std::string text;
        const char* words;
    } cases[] = {
        {"", "is no URDF"},
        {"Dear reader\n", "is no URDF"},
        {std::string("\x89PNG\r\n\0\0", 8), "is no URDF"},
        {"<robot name='a'>\n<link name='b'>", "cart.urdf:2"},
        {"<sdf version='1.6'/>", "outermost element is <sdf>"},
        {robot("<xacro:include filename='x'/>"), "xacro cart.urdf"},
        {robot(""), "no links"},
        {robot(link("a")), "no link has a geometry"},
        {robot(link("a") + link("a")), "cart.urdf:4: there are two links 'a'"},
        {robot(link("a") + link("b")), "no joint connects the links 'a' and 'b'"},
        {robot(link("a") + joint("a", "c", "xyz='0 0 0'")), "names the link 'c', which does not exist"},
        {robot(link("a") + link("b") + joint("a", "b", "xyz='0 0'")), "must be 3 numbers"},
        {robot(link("a") + link("b") + joint("a", "b", "xyz='0 0 1e9'")), "must be 3 numbers"},
        {robot(link("a") + link("b") + joint("a", "b", "") + joint("b", "a", "")), "in a circle"},
        {robot(link("a") + link("b") + link("c") + joint("a", "b", "") + joint("c", "b", "")), "hangs on two joints"},
        {robot(link("a", visual("<box size='1 1 nan'/>"))), "size=\"1 1 nan\" of <box> must be 3 numbers"},
        {robot(link("a", visual("<box size='1 1 0'/>"))), "must be 3 numbers"},
        {robot(link("a", visual("<box/>"))), "<box> needs the attribute 'size'"},
        {robot(link("a", visual("<capsule radius='1'/>"))), "must be box, cylinder, sphere or mesh, not 'capsule'"},
        {robot("<link/>"), "needs the attribute 'name'"},
        {robot("<joint name='a'/>" + link("b")), "needs <parent> and <child>"},
    };
    for (const auto& c : cases) {
        const auto model = parse_urdf(c.text, "cart.urdf");
        ASSERT_FALSE(model) << c.words;
        EXPECT_TRUE(has(model.error().message, "cart.urdf")) << model.error().message;
        EXPECT_TRUE(has(model.error().message, c.words)) << model.error().message;
    }
    std::string deep = "<robot>";
    for (int i = 0; i < 100000; ++i) deep += "<a>";
    EXPECT_FALSE(parse_urdf(deep, "deep.urdf"));
}

}  // namespace
}  // namespace roomfix
