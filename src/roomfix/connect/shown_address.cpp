#include "roomfix/connect/shown_address.hpp"

#include <algorithm>
#include <string_view>

namespace roomfix {

/// Where the host begins, behind user and password. A password may hold a slash where nobody wrote it as %2F: then there is a colon before the slash that no
/// port follows, and an @ behind it.
static std::size_t host_of(std::string_view address, std::size_t begin) {
    const std::size_t end = std::min(address.find_first_of("/?#", begin), address.size());
    const std::string_view authority = address.substr(begin, end - begin);
    if (const std::size_t at = authority.rfind('@'); at != std::string_view::npos) return begin + at + 1;
    const std::size_t colon = authority.find(':');
    const bool port = colon == std::string_view::npos || authority.find_first_not_of("0123456789", colon + 1) == std::string_view::npos;
    const std::size_t at = address.rfind('@');
    return port || at == std::string_view::npos || at < begin ? begin : at + 1;
}

std::string shown_address(const std::string& address) {
    const std::size_t start = address.find("://");
    if (start == std::string::npos) return address;
    const std::size_t begin = start + 3;
    const std::string shown = address.substr(0, begin) + address.substr(host_of(address, begin));
    return shown.substr(0, shown.find('?'));  // many cameras take user and password there
}

}  // namespace roomfix
