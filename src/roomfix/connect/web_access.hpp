// Where a server of this program listens, and who may ask it.
#pragma once

#include <optional>
#include <string>

#include "roomfix/base/result.hpp"
#include "roomfix/site/site.hpp"

namespace roomfix {

struct WebAccess {
    std::string host = "127.0.0.1";
    int port = 0;             // 0: a free one
    std::string certificate;  // PEM files; empty: not encrypted
    std::string key;
    std::string token;           // that whoever looks must know; empty: everybody may look
    std::string operator_token;  // that whoever changes something must know; empty: nobody may
};

enum class WebRole { nobody, viewer, operating };

/// As the site file says it, with its secrets. An error where a secret is not there, or where others could look who must not; `what` listens, for the message.
Result<WebAccess> web_access(const WebOutput& web, const Site& site, const std::string& what);

/// Compares without letting the time that it takes tell how much was right.
bool same_token(const std::string& given, const std::string& token);
/// Does an Authorization header show the token: "Bearer TOKEN", or "Basic" with the token as the password of whatever name?
bool shows_token(const std::string& authorization, const std::string& token);
/// What somebody with this Authorization header may do. The operator may look, too.
WebRole role_of(const WebAccess& access, const std::string& authorization);

/// Of a request that wants to change something.
struct ChangeHeaders {
    std::string origin;                       // of the page that sends it; empty: no page does
    std::string host;                         // that it is sent to
    std::optional<std::string> content_type;  // nothing: it has no body
};

/// Could another site's page, open in the browser of an operator, have sent this? An empty text: it could not. Such a page can send no JSON, no PUT and no
/// DELETE unless we agree to it beforehand, which we never do; and its browser names its origin.
std::string foreign_change(const ChangeHeaders& headers);

}  // namespace roomfix
