// Any bytes as a camera_info file or as a lens grid.
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "roomfix/connect/camera_info.hpp"
#include "roomfix/site/lens_grid_file.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace roomfix;
    if (size < 1) return 0;
    const std::string_view text(reinterpret_cast<const char*>(data) + 1, size - 1);
    if (data[0] % 2 == 0) {
        const auto info = parse_camera_info(text);
        if (!info) return 0;
        (void)parse_camera_info(camera_info_text(*info));
        (void)unproject(info->model, {10, 20});
        return 0;
    }
    const auto grid = parse_lens_grid(text);
    if (!grid) return 0;
    const Eigen::Vector2d middle = 0.5 * (grid->seen().front() + grid->seen().back());
    (void)grid->corrected(middle);
    (void)grid->distorted(middle);
    return 0;
}
