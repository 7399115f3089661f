#include "roomfix/connect/tls_problem.hpp"

#include <httplib.h>

namespace roomfix {

std::string tls_problem(const std::string& host, int port, const std::string& ca) {
    constexpr int patience = 3;  // s
    httplib::SSLClient client(host, port);
    if (!ca.empty()) client.set_ca_cert_path(ca.c_str());
    client.enable_server_certificate_verification(true);
    client.set_connection_timeout(patience);
    client.set_read_timeout(patience);
    const auto answer = client.Get("/");  // a server of something else answers nothing, but its certificate has been looked at
    const long verified = client.get_openssl_verify_result();
    if (verified != X509_V_OK) return X509_verify_cert_error_string(verified);
    return answer.error() == httplib::Error::SSLServerVerification ? "it is for another host than " + host : "";
}

}  // namespace roomfix
