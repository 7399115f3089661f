#include "roomfix/site/edit_site.hpp"

#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <filesystem>
#include <fstream>

#include "roomfix/site/load_site.hpp"
#include "roomfix/site/site_text.hpp"

namespace roomfix {
namespace {

const std::string lab_site = R"(roomfix: 1   # our lab
site: {name: lab}
cameras:
  up:   # the cheap one
    source: frames/up
    size: [352, 288]
    intrinsics: {fx: 300, fy: 300, cx: 175.5, cy: 143.5}
    MOUNT
    # below the mount
  other:
    source: frames/other
    size: [352, 288]
    intrinsics: {fx: 300, fy: 300, cx: 175.5, cy: 143.5}
    mount: {robot: r1, position: [0, 0, 0.1], quaternion: [0, 0, 0, 1]}
robots:
  r1: {shape: box, size: [0.54, 0.54, 0.45]}
)";

std::string with_mount_as(const std::string& mount) {
    std::string changed = lab_site;
    return changed.replace(changed.find("MOUNT"), 5, mount);
}

Result<std::string> with_camera_values(std::string_view before, const std::string& camera, const std::vector<SiteValue>& values) {
    return with_values(before, {camera, values});
}

/// Another mount, with a covariance.
std::vector<SiteValue> new_mount() {
    Mount mount{"r1", {}, true};
    mount.robot_from_camera.pose.translation() = Eigen::Vector3d(0.01, 0.02, 0.31);
    mount.robot_from_camera.covariance = 1e-6 * Matrix6d::Identity();
    return {{"mount", mount_text(mount, CameraModel{})}};
}

TEST(EditSite, ReplacesTheMountAndNothingElse) {
    for (const std::string mount :
         {"mount: {robot: r1, position: [0, 0, 0.3], quaternion: [0, 0, 0, 1]}  # measured",
          "mount:\n      robot: r1   # {not a brace}\n      position: [0, 0, 0.3]\n      quaternion:\n        - 0\n        - 0\n        - 0\n        - 1",
          "mount:   # {measured}\n      robot: r1\n      position: [0, 0, 0.3]\n      quaternion: [0, 0, 0, 1]",
          "mount: {robot: r1, # why\n      position: [0, 0,\n 0.3], quaternion: [0, 0, 0, 1]}"}) {
        const auto changed = with_camera_values(with_mount_as(mount), "up", new_mount());
        ASSERT_TRUE(changed) << changed.error().message;
        const LoadedSite loaded = parse_site(*changed, "/");
        for (const auto& p : loaded.problems) EXPECT_FALSE(p.fatal) << p.message << "\n" << *changed;
        const auto& up = std::get<Mount>(loaded.site.cameras[0].placement);
        EXPECT_EQ(up.robot_from_camera.pose.translation().z(), 0.31);
        EXPECT_TRUE(up.has_covariance);
        EXPECT_EQ(std::get<Mount>(loaded.site.cameras[1].placement).robot_from_camera.pose.translation().z(), 0.1);
        for (const char* kept : {"# our lab", "# the cheap one", "# below the mount"}) EXPECT_NE(changed->find(kept), std::string::npos) << kept;
    }
    EXPECT_FALSE(with_camera_values(with_mount_as("height: 1"), "down", new_mount())) << "there is no such camera";
    EXPECT_FALSE(with_camera_values("a: [", "up", new_mount()));
}

TEST(EditSite, AddsAndRemovesKeysInBlocksAndInBraces) {
    const std::string points =
        "floor_points_sigma: 0.5 # clicked\n    floor_points:\n      - {pixel: [1, 2], map: [0, 0]}\n      - {pixel: [2, 2], map: [0, 1]}";
    const std::string braces =
        "roomfix: 1\ncameras: {up: {source: 'a, b', floor_points_sigma: 1, floor_points: [{pixel: [1, 2], map: [0, 0]}], size: [3, 4]}}\n";
    for (const std::string& before : {with_mount_as(points), braces}) {
        const auto changed =
            with_camera_values(before, "up", {{"pose", "{position: [1, 2, 3]}"}, {"floor_points", ""}, {"floor_points_sigma", ""}, {"mount", ""}});
        ASSERT_TRUE(changed) << changed.error().message;
        const YAML::Node up = YAML::Load(*changed)["cameras"]["up"];
        EXPECT_EQ(up["pose"]["position"][2].as<int>(), 3) << *changed;
        EXPECT_FALSE(up["floor_points"].IsDefined() || up["floor_points_sigma"].IsDefined()) << *changed;
        EXPECT_EQ(up["size"].size(), 2U) << *changed;
    }
    const auto scalar = with_camera_values(with_mount_as("background: 'empty # hall'  # at night"), "up", {{"background", "other"}});
    ASSERT_TRUE(scalar);
    EXPECT_NE(scalar->find("background: other  # at night"), std::string::npos) << *scalar;
}

TEST(EditSite, KeepsTheFileAsItWas) {
    const auto folder = std::filesystem::temp_directory_path() / "roomfix_edit_site";
    std::filesystem::create_directories(folder);
    const auto file = folder / "site.yaml";
    const std::string before = with_mount_as("mount: {robot: r1, position: [0, 0, 0.3], quaternion: [0, 0, 0, 1]}");
    std::ofstream(file) << before;
    const auto copy = write_site_values(file, {{"up", new_mount()}});
    ASSERT_TRUE(copy) << copy.error().message;
    std::ifstream old(*copy);
    EXPECT_EQ(std::string(std::istreambuf_iterator<char>(old), {}), before);
    EXPECT_FALSE(write_site_values(folder / "missing.yaml", {{"up", new_mount()}}));
    std::filesystem::remove_all(folder);
}

TEST(EditSite, WritesSeveralCamerasOrNone) {
    const auto folder = std::filesystem::temp_directory_path() / "roomfix_edit_sites";
    std::filesystem::create_directories(folder);
    const auto file = folder / "site.yaml";
    const std::string before = "cameras:\n  a: {source: x}  # left\n  b: {source: y}\n";
    std::ofstream(file) << before;
    const auto written = [&] {
        std::ifstream now(file);
        return std::string(std::istreambuf_iterator<char>(now), {});
    };
    EXPECT_FALSE(write_site_values(file, {{"a", {{"source", "z"}}}, {"c", {{"source", "z"}}}}));
    EXPECT_EQ(written(), before);
    ASSERT_TRUE(write_site_values(file, {{"a", {{"source", "v"}}}, {"b", {{"source", "w"}}}}));
    EXPECT_EQ(written(), "cameras:\n  a: {source: v}  # left\n  b: {source: w}\n");
    std::filesystem::remove_all(folder);
}

TEST(EditSite, TakesAWholeSectionOut) {
    const std::string block = "site: {name: x}\noutputs:  # where to\n  web: {port: 1}\n  mqtt:\n    host: broker\n# robots\nrobots:\n  r1: {count: many}\n";
    EXPECT_EQ(*without_section(block, "outputs"), "site: {name: x}\n# robots\nrobots:\n  r1: {count: many}\n");
    EXPECT_EQ(*without_section("site: {name: x}\noutputs: {web: {port: 1}}\n", "outputs"), "site: {name: x}\n");
    EXPECT_EQ(*without_section("{site: {name: x}, outputs: {web: {}}, robots: {}}", "outputs"), "{site: {name: x}, robots: {}}");
    EXPECT_EQ(*without_section("site: {name: x}\n", "outputs"), "site: {name: x}\n");
    EXPECT_FALSE(without_section("site: {name: x\n", "outputs"));
}

/// The zones of a text after one of them was changed in it.
std::string zones_after(const std::string& text, const std::string& id, const std::string& value) {
    const auto changed = with_entry(text, "zones", {id, value});
    if (!changed) return changed.error().message;
    std::string told;
    for (const auto& zone : YAML::Load(*changed)["zones"]) told += zone.first.Scalar() + std::to_string(zone.second.size()) + " ";
    return told + (changed->find("# kept") == std::string::npos ? "without the comment" : "");
}

TEST(EditSite, ChangesEntriesOfASectionHoweverItIsWritten) {
    const std::string triangle = "[[0, 0], [1, 0], [0, 1]]", square = "[[0, 0], [1, 0], [1, 1], [0, 1]]";
    const std::string head = "site: {name: x}  # kept\n";
    for (const std::string& zones :
         std::initializer_list<std::string>{std::string("zones:\n  a: ") + triangle + "\n  b: " + triangle + "\n",       // blocks
                                            "zones: {a: " + triangle + ", b: " + triangle + "}\n",                       // braces
                                            "zones:\n  a:\n    - [0, 0]\n    - [1, 0]\n    - [0, 1]\n  b: " + triangle,  // without a newline at the end
                                            "zones:\n  a:\n  - [0, 0]\n  - [1, 0]\n  - [0, 1]\n  b:\n  - [0, 0]\n  - [1, 0]\n  - [0, 1]\nrobots: {}\n",
                                            "zones:\n    a: [[0, 0],\n  [1, 0], [0, 1]]\n    b: " + triangle + "\noutputs: {}\n"}) {
        EXPECT_EQ(zones_after(head + zones, "a", square), "a4 b3 ") << zones;
        EXPECT_EQ(zones_after(head + zones, "b", square), "a3 b4 ") << zones;
        EXPECT_EQ(zones_after(head + zones, "c", square), "a3 b3 c4 ") << zones;
        EXPECT_EQ(zones_after(head + zones, "a", ""), "b3 ") << zones;
        EXPECT_EQ(zones_after(head + zones, "b", ""), "a3 ") << zones;
        EXPECT_EQ(zones_after(head + zones, "c", ""), "a3 b3 ") << zones;
    }
    for (const std::string& none : {"", "zones:\n", "zones: {}\n", "zones: {}  # none yet\nrobots: {}\n", "outputs: {}"}) {
        EXPECT_EQ(zones_after(head + none, "a", square), "a4 ") << none;
        EXPECT_EQ(zones_after(head + none, "a", ""), "") << none;
    }
    EXPECT_EQ(*with_entry("{site: {name: x}}", "zones", {"a", triangle}), "{site: {name: x}, zones: {a: " + triangle + "}}");
    EXPECT_EQ(*with_entry("site: {name: x}\nzones:\n  a: " + triangle + "\nrobots: {}\n", "zones", {"a", ""}), "site: {name: x}\nrobots: {}\n");
    EXPECT_FALSE(with_entry("a: [", "zones", {"a", triangle}));
    EXPECT_FALSE(with_entry("", "zones", {"a", triangle}));
}

TEST(EditSite, AFilesModeStaysAndALinkLeadsToItAsBefore) {
    const auto folder = std::filesystem::temp_directory_path() / "roomfix_replace_file";
    std::filesystem::create_directories(folder);
    std::ofstream(folder / "site.yaml") << "before";
    std::filesystem::permissions(folder / "site.yaml", std::filesystem::perms(0640));
    std::filesystem::create_symlink("site.yaml", folder / "link.yaml");
    ASSERT_TRUE(replace_file(folder / "link.yaml", "after", folder / "copy"));
    EXPECT_TRUE(std::filesystem::is_symlink(folder / "link.yaml"));
    EXPECT_EQ(std::filesystem::status(folder / "site.yaml").permissions(), std::filesystem::perms(0640));
    std::ifstream now(folder / "link.yaml"), copy(folder / "copy");
    EXPECT_EQ(std::string(std::istreambuf_iterator<char>(now), {}), "after");
    EXPECT_EQ(std::string(std::istreambuf_iterator<char>(copy), {}), "before");
    std::filesystem::create_directory(folder / "site.yaml.new");  // nothing can be written there
    const auto failed = replace_file(folder / "site.yaml", "never", folder / "copy");
    ASSERT_FALSE(failed);
    EXPECT_NE(failed.error().message.find("cannot be written"), std::string::npos);
    std::ifstream still(folder / "site.yaml");
    EXPECT_EQ(std::string(std::istreambuf_iterator<char>(still), {}), "after");
    EXPECT_FALSE(replace_file(folder / "none.yaml", "never", folder / "copy"));
    std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace roomfix
