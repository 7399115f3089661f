// Lines that come by UDP.
#pragma once

#include <string>

#include "roomfix/base/result.hpp"

namespace roomfix {

class UdpPort {
public:
    /// `address`: "udp://HOST:PORT", HOST an address of this machine. Anybody who reaches it could send readings: beyond this machine it must end in
    /// "?insecure". An error says why it cannot be used and what to try.
    static Result<UdpPort> open(const std::string& address);
    ~UdpPort();
    UdpPort(UdpPort&& other) noexcept;
    UdpPort& operator=(UdpPort&&) = delete;

    /// Waits up to `seconds` for datagrams and appends those that are there, each as whole lines; some, if there are very many. False if nothing can come any
    /// more.
    bool read(double seconds, std::string& lines);

private:
    explicit UdpPort(int socket) : socket_(socket) {}
    int socket_;
};

}  // namespace roomfix
