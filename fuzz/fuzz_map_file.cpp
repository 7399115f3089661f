// Any text as the map file of a map_server: a sentence, or a map that can be shown.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "roomfix/site/read_plan.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const auto map = roomfix::parse_map_file({reinterpret_cast<const char*>(data), size});
    if (!map) return 0;
    const auto& origin = map->map_from_plan;
    if (!(map->resolution > 0) || map->image.empty() || !std::isfinite(origin.x) || !std::isfinite(origin.y) || !std::isfinite(origin.yaw)) __builtin_trap();
    return 0;
}
