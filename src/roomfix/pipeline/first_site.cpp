#include "roomfix/pipeline/first_site.hpp"

#include <fmt/format.h>

#include "roomfix/base/number.hpp"

namespace roomfix {
namespace {

std::string camera_text(const FirstCamera& camera) {
    const double focal = 0.87 * camera.width;  // of a lens that sees 60 deg across
    std::string text = fmt::format("  {}:\n    source: {}\n    size: [{}, {}]\n", camera.id, camera.source, camera.width, camera.height);
    text += fmt::format(
        "    # A guess, for a lens that sees 60 deg from left to right. `roomfix calibrate lens` measures it from pictures of a printed board.\n"
        "    intrinsics: {{fx: {0:.0f}, fy: {0:.0f}, cx: {1}, cy: {2}}}\n",
        focal, number_text(0.5 * (camera.width - 1)), number_text(0.5 * (camera.height - 1)));
    text +=
        "    # Where it hangs: four or more points on the floor, spread over all of it, with their pixels and their places on the map (m), such as\n"
        "    #   - {pixel: [325.3, 662.3], map: [2, 1]}\n"
        "    floor_points: []\n"
        "    # background: empty.mp4    # half a minute of it without robots\n";
    return text;
}

std::string robot_text(const FirstRobot& robot) {
    std::string sizes;
    for (const double size : robot.sizes) sizes += (sizes.empty() ? "" : ", ") + number_text(size);
    return fmt::format("  {}: {{shape: {}, size: [{}]}}\n", robot.id, robot.round ? "cylinder" : "box", sizes);
}

}  // namespace

std::string first_site_text(const FirstSite& site) {
    std::string text = fmt::format("roomfix: 1\nsite:\n  name: {}\n", site.name);
    if (site.ceiling > 0) text += fmt::format("  ceiling: {}\n", number_text(site.ceiling));
    text += "  # walls: [[[0, 0], [6, 0], [6, 5], [0, 5], [0, 0]]]    # lines on the map (m), for the picture and for what hides robots\n";
    if (!site.cameras.empty()) text += "cameras:\n";
    for (const FirstCamera& camera : site.cameras) text += camera_text(camera);
    if (!site.robots.empty()) text += "robots:\n";
    for (const FirstRobot& robot : site.robots) text += robot_text(robot);
    text +=
        "outputs:\n  web: {}    # {operator: {file: operator-token}}: who knows what stands in that file draws zones on the page\n  # jsonl: fixes.jsonl\n  # "
        "mqtt: {host: broker.local}\n  # ros2: {domain: 0}\n  # history: {database: history.db}\n";
    return text;
}

}  // namespace roomfix
