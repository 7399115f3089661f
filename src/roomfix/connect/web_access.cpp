#include "roomfix/connect/web_access.hpp"

#include <fmt/format.h>

#include <optional>
#include <string_view>

#include "roomfix/connect/secret.hpp"

namespace roomfix {

Result<WebAccess> web_access(const WebOutput& web, const Site& site, const std::string& what) {
    if (const std::string reason = refusal(web, what); !reason.empty()) return Error{reason};
    WebAccess access{web.host, web.port};
    if (web.tls) {
        access.certificate = resolved_path(site, web.tls->certificate);
        access.key = resolved_path(site, web.tls->key);
    }
    if (web.token) {
        auto token = secret_text(*web.token, site, "the token of " + what);
        if (!token) return token.error();
        access.token = *token;
    }
    if (web.operator_token) {
        auto token = secret_text(*web.operator_token, site, "the operator's token of " + what);
        if (!token) return token.error();
        if (*token == access.token) return Error{fmt::format("the operator's token of {} is that of everybody who looks: make another one", what)};
        access.operator_token = *token;
    }
    return access;
}

bool same_token(const std::string& given, const std::string& token) {
    if (given.size() != token.size()) return false;
    unsigned char difference = 0;
    for (std::size_t i = 0; i < given.size(); ++i) difference = static_cast<unsigned char>(difference | (given[i] ^ token[i]));
    return difference == 0;
}

/// The bytes of a base64 text; nothing if it is none.
static std::optional<std::string> from_base64(std::string_view text) {
    std::string bytes;
    unsigned bits = 0;
    int count = 0;
    while (text.ends_with('=')) text.remove_suffix(1);
    for (const char c : text) {
        unsigned value = 0;
        if (c >= 'A' && c <= 'Z')
            value = static_cast<unsigned>(c - 'A');
        else if (c >= 'a' && c <= 'z')
            value = static_cast<unsigned>(c - 'a') + 26;
        else if (c >= '0' && c <= '9')
            value = static_cast<unsigned>(c - '0') + 52;
        else if (c == '+')
            value = 62;
        else if (c == '/')
            value = 63;
        else
            return std::nullopt;
        bits = bits << 6 | value;
        count += 6;
        if (count < 8) continue;
        count -= 8;
        bytes += static_cast<char>(bits >> count & 0xff);
    }
    return bytes;
}

bool shows_token(const std::string& authorization, const std::string& token) {
    if (authorization.starts_with("Bearer ")) return same_token(authorization.substr(7), token);
    if (!authorization.starts_with("Basic ")) return false;
    const auto pair = from_base64(std::string_view(authorization).substr(6));
    const std::size_t colon = pair ? pair->find(':') : std::string::npos;
    return colon != std::string::npos && same_token(pair->substr(colon + 1), token);
}

WebRole role_of(const WebAccess& access, const std::string& authorization) {
    if (!access.operator_token.empty() && shows_token(authorization, access.operator_token)) return WebRole::operating;
    return access.token.empty() || shows_token(authorization, access.token) ? WebRole::viewer : WebRole::nobody;
}

std::string foreign_change(const ChangeHeaders& headers) {
    if (headers.content_type && headers.content_type->substr(0, headers.content_type->find(';')) != "application/json") {
        return "changes are JSON: send Content-Type: application/json";
    }
    if (headers.origin.empty()) return "";
    const std::size_t host = headers.origin.find("://");
    if (host != std::string::npos && headers.origin.substr(host + 3) == headers.host) return "";
    return "changes come from the page itself, not from another site's (a proxy in between must pass the Host header on)";
}

}  // namespace roomfix
