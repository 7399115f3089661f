// Why a server's certificate is not believed.
#pragma once

#include <string>

namespace roomfix {

/// Shakes hands with the server once more, to be able to say it: OpenSSL's libraries tell their users only that it failed. `ca`: file of those who are
/// believed; empty: the system's. Empty if there is nothing wrong with the certificate. Takes some seconds where the server does not answer.
std::string tls_problem(const std::string& host, int port, const std::string& ca);

}  // namespace roomfix
