// Any text as a site file: problems, never a crash.
#include <string_view>

#include "roomfix/site/load_site.hpp"

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
    const roomfix::LoadedSite loaded = roomfix::parse_site({reinterpret_cast<const char*>(data), size}, "/");
    if (!loaded.usable()) return 0;
    for (const auto& camera : loaded.site.cameras) (void)roomfix::fixed_view(camera);
    return 0;
}
