#include "roomfix/connect/shown_address.hpp"

namespace roomfix {

std::string shown_address(const std::string& address) {
    const std::size_t start = address.find("://");
    if (start == std::string::npos) return address;
    const std::size_t host = start + 3;
    // A password may hold any character, and many cameras take it behind the question mark.
    const std::size_t at = address.rfind('@');
    const std::string shown = at == std::string::npos || at < host ? address : address.substr(0, host) + address.substr(at + 1);
    return shown.substr(0, shown.find('?'));
}

}  // namespace roomfix
