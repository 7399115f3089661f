#include "roomfix/site/outputs.hpp"

#include <fmt/format.h>

namespace roomfix {

bool is_loopback(const std::string& host) { return host == "localhost" || host == "::1" || host.starts_with("127."); }

std::string refusal(const WebOutput& web, const std::string& what) {
    if (is_loopback(web.host)) return "";
    if (web.operator_token && !web.tls) return fmt::format("the operator's token of {} would cross the network for everybody to read: give it 'tls'", what);
    if (web.insecure || (web.tls && web.token)) return "";
    return fmt::format(
        "{} would be open to everybody who reaches {}: give it 'tls' and a 'token' in the site file, or allow it by 'insecure: true' or --insecure", what,
        web.host);
}

}  // namespace roomfix
