// Where a server of this program listens, and who may ask it.
#pragma once

#include <string>

#include "roomfix/base/result.hpp"
#include "roomfix/site/site.hpp"

namespace roomfix {

struct WebAccess {
    std::string host = "127.0.0.1";
    int port = 0;             // 0: a free one
    std::string certificate;  // PEM files; empty: not encrypted
    std::string key;
    std::string token;  // empty: everybody
};

/// As the site file says it, with its secrets. An error where a secret is not there, or where others could look who must not; `what` listens, for the message.
Result<WebAccess> web_access(const WebOutput& web, const Site& site, const std::string& what);

/// Compares without letting the time that it takes tell how much was right.
bool same_token(const std::string& given, const std::string& token);
/// Does an Authorization header show the token: "Bearer TOKEN", or "Basic" with the token as the password of whatever name?
bool shows_token(const std::string& authorization, const std::string& token);

}  // namespace roomfix
