// Any bytes as odometry, as sightings, as the times' errors, as fixes or as truth, through to the report.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "roomfix/connect/odometry_source.hpp"
#include "roomfix/connect/sighting_source.hpp"
#include "roomfix/connect/time_errors.hpp"
#include "roomfix/evaluate/error_report.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace roomfix;
    if (size < 1) return 0;
    const std::string_view text(reinterpret_cast<const char*>(data) + 1, size - 1);
    Site site;
    site.robots.resize(1);
    site.robots[0].id = "r1";
    switch (data[0] % 5) {
        case 0:
            (void)parse_odometry(text, site, size % 2 == 0 ? 0 : -1);
            break;
        case 1: {
            Truth truth;
            for (int i = 0; i < 20; ++i) {
                truth["r1"].push_back({from_seconds(0.1 * i), {0.1 * i, 1, 0}});
                truth["unknown-1"].push_back({from_seconds(0.1 * i), {0.1 * i, 2, 0}, false});
            }
            const ErrorReport report = judge(parse_fixes(text), truth);
            (void)html_of(report, "fuzz");
            (void)text_of(report);
            (void)json_of(report);
            break;
        }
        case 3: {
            site.landmarks = {{"post1", PointMark{}}, {"post2", PointMark{}}};
            const auto batch = parse_sightings(text, site, size % 2 == 0 ? 0 : -1);
            if (!batch) break;
            for (const SightingObservation& o : batch->sightings) {
                const bool range = !o.range || (*o.range > 0 && std::isfinite(*o.range) && o.range_sigma > 0);
                const bool bearing = !o.bearing || (std::abs(*o.bearing) < 7 && o.bearing_sigma > 0);
                if (!range || !bearing || o.landmark > 1 || o.robot != 0) __builtin_trap();
            }
            break;
        }
        case 4: {
            const auto changes = parse_time_errors(text);
            if (!changes) break;
            for (const TimeErrorChange& change : *changes) {
                if (!(change.error.sigma >= 0) || change.error.way < 0) __builtin_trap();
                if (parse_time_errors(time_error_line(change))->front().time != change.time) __builtin_trap();
            }
            break;
        }
        default: {
            const auto truth = parse_truth(text);
            if (truth)
                (void)judge(parse_fixes(
                                R"({"time": 0.5, "robot": "r1", "status": "ok", "x": 0, "y": 0, "yaw": null, "covariance": [1,0,0,0,1,0,0,0,1], "sources": []}
{"time": 0.5, "robot": null, "kind": "unknown", "id": "unknown-1", "status": "ok", "x": 0, "y": 0, "covariance": [1,0,0,0,1,0,0,0,1]})"),
                            *truth);
        }
    }
    return 0;
}
