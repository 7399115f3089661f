// Any bytes from a serial line or a file, in pieces of any size.
#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "roomfix/ranging/range_reader.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    roomfix::Site site;
    site.robots.resize(1);
    site.robots[0].id = "r1";
    site.beacons = {{"n1", {0, 0, 3}, "01:25:61:61:0b:00:00:42"}, {"ship", {4, 0, 3}, ""}};
    const std::size_t piece = size > 0 ? 1 + data[0] : 1;
    roomfix::RangeReader reader(site, size % 2 == 0 ? 0 : -1);
    roomfix::RangeBatch batch;
    for (std::size_t at = 0; at < size; at += piece) {
        reader.feed({reinterpret_cast<const char*>(data) + at, std::min(piece, size - at)}, 5, batch);
    }
    reader.finish(5, batch);
    for (const auto& range : batch.ranges) {
        if (!(range.range > 0 && range.range <= 200 && range.sigma > 0)) __builtin_trap();
    }
    return 0;
}
