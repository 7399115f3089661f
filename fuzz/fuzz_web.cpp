// Any bytes as a zone that is drawn, as an address and as a token: what is taken is right.
#include <cstddef>
#include <cstdint>
#include <string>

#include "roomfix/connect/web_routes.hpp"
#include "roomfix/connect/zone_answer.hpp"
#include "roomfix/site/read_zone.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace roomfix;
    const std::string text(reinterpret_cast<const char*>(data), size);
    const auto border = parse_zone_border(text);
    if (border && !border_problem(*border).empty()) __builtin_trap();
    for (const std::string_view route : web_routes) {
        const auto id = id_in(text, route);
        if (id && id->find_first_not_of("ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_-") != std::string::npos) __builtin_trap();
    }
    const WebAccess access{"127.0.0.1", 0, "", "", "a token that looks", "a token that changes"};
    const bool shown = text.find("changes") != std::string::npos || text.find("Basic ") != std::string::npos;
    if (role_of(access, text) == WebRole::operating && !shown) __builtin_trap();
    (void)foreign_change({text, "host", text});
    return 0;
}
