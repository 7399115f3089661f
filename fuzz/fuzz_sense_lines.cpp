// Any bytes as readings that come by UDP or MQTT.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "roomfix/connect/sense_lines.hpp"
#include "roomfix/site/load_site.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace roomfix;
    static const Site site =
        parse_site(
            "roomfix: 1\nsite: {name: s}\nrobots:\n"
            "  a: {shape: box, size: [1, 1, 1], receiver: {position: [0, 0, 0], source: 'udp://127.0.0.1:1'}, odometry: {source: 'udp://127.0.0.1:1'}}\n"
            "  b: {shape: box, size: [1, 1, 1], detector: {source: 'udp://127.0.0.1:1'}}\n"
            "beacons: {n: {position: [0, 0, 2]}}\nlandmarks: {post: {position: [1, 2, 0]}}\n",
            "/")
            .site;
    SenseLines lines(site, "udp://127.0.0.1:1");
    const std::string_view text(reinterpret_cast<const char*>(data), size);
    const auto robots = static_cast<int>(site.robots.size());
    for (int i = 0; i < 2; ++i) {
        const Readings readings = lines.read(text, from_seconds(1000 + i), 10.0 + i);
        for (const auto& pose : readings.odometry.poses) {
            if (pose.robot < 0 || pose.robot >= robots || !std::isfinite(pose.pose.x + pose.pose.y + pose.pose.yaw)) __builtin_trap();
        }
        for (const auto& range : readings.ranges.ranges) {
            if (range.robot < 0 || range.robot >= robots || !std::isfinite(range.range)) __builtin_trap();
        }
        for (const auto& sighting : readings.sightings.sightings) {
            if (sighting.robot < 0 || sighting.robot >= robots) __builtin_trap();
        }
    }
    (void)lines.clocks();
    return 0;
}
