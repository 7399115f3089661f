#include "roomfix/connect/shown_address.hpp"

namespace roomfix {

std::string shown_address(const std::string& address) {
    const std::size_t start = address.find("://");
    if (start == std::string::npos) return address;
    const std::size_t host = start + 3;
    const std::size_t at = address.substr(host, address.find_first_of("/?#", host) - host).rfind('@');
    return at == std::string::npos ? address : address.substr(0, host) + address.substr(host + at + 1);
}

}  // namespace roomfix
