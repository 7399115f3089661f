#include "roomfix/connect/udp_port.hpp"

#include <fmt/format.h>
#include <netdb.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <memory>
#include <optional>
#include <utility>

#include "roomfix/base/number.hpp"
#include "roomfix/site/outputs.hpp"

namespace roomfix {
namespace {

constexpr std::size_t largest_datagram = 65536;
constexpr std::size_t most_at_once = 1 << 20;  // bytes, so that a flood does not keep the reader from telling what came

struct Address {
    std::string host, port;
    bool insecure = false;
};

std::optional<Address> parse(std::string text) {
    constexpr std::string_view scheme = "udp://", allowance = "?insecure";
    if (!text.starts_with(scheme)) return std::nullopt;
    text.erase(0, scheme.size());
    Address address;
    if (text.ends_with(allowance)) {
        address.insecure = true;
        text.resize(text.size() - allowance.size());
    }
    const std::size_t colon = text.rfind(':');
    if (colon == std::string::npos) return std::nullopt;
    address.host = text.substr(0, colon);
    address.port = text.substr(colon + 1);
    if (address.host.size() > 2 && address.host.front() == '[' && address.host.back() == ']') address.host = address.host.substr(1, address.host.size() - 2);
    const auto number = parse_integer(address.port);
    return number && *number > 0 && *number < 65536 && !address.host.empty() ? std::optional(address) : std::nullopt;
}

}  // namespace

Result<UdpPort> UdpPort::open(const std::string& text) {
    const auto address = parse(text);
    if (!address) return Error{fmt::format("{}: is no address to listen at: write udp://127.0.0.1:5005", text)};
    if (!is_loopback(address->host) && !address->insecure) {
        return Error{fmt::format("{}: whoever reaches this machine could send readings: write {}?insecure if that is all right, or use MQTT", text, text)};
    }
    addrinfo wish = {};
    wish.ai_socktype = SOCK_DGRAM;
    wish.ai_flags = AI_PASSIVE | AI_NUMERICSERV;
    addrinfo* found = nullptr;
    if (const int code = getaddrinfo(address->host.c_str(), address->port.c_str(), &wish, &found); code != 0) {
        return Error{fmt::format("{}: {}: the host must be an address of this machine", text, gai_strerror(code))};
    }
    const std::unique_ptr<addrinfo, void (*)(addrinfo*)> freed(found, freeaddrinfo);
    UdpPort port(::socket(found->ai_family, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
    if (port.socket_ < 0 || ::bind(port.socket_, found->ai_addr, found->ai_addrlen) != 0) {
        return Error{fmt::format("{}: cannot be listened at ({}): another program may have the port, or the address is not one of this machine", text,
                                 std::strerror(errno))};
    }
    return port;
}

UdpPort::~UdpPort() {
    if (socket_ >= 0) ::close(socket_);
}

UdpPort::UdpPort(UdpPort&& other) noexcept : socket_(std::exchange(other.socket_, -1)) {}

bool UdpPort::read(double seconds, std::string& lines) {
    pollfd waiting{socket_, POLLIN, 0};
    const int ready = ::poll(&waiting, 1, static_cast<int>(seconds * 1000));
    if (ready == 0 || (ready < 0 && errno == EINTR)) return true;
    if (ready < 0) return false;
    std::array<char, largest_datagram> buffer;
    while (lines.size() < most_at_once) {
        const ssize_t count = ::recv(socket_, buffer.data(), buffer.size(), 0);
        if (count < 0) return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR;
        lines.append(buffer.data(), static_cast<std::size_t>(count));
        if (lines.empty() || lines.back() != '\n') lines += '\n';
    }
    return true;
}

}  // namespace roomfix
