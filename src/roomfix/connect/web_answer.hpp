// Questions to the web server that somebody else answers.
#pragma once

#include <functional>
#include <map>
#include <string>

#include "roomfix/connect/web_access.hpp"

namespace roomfix {

using WebParameters = std::multimap<std::string, std::string>;  // of the address, behind the question mark, decoded

struct WebQuestion {
    WebParameters parameters;
    std::string id;    // what stands in the address for {id}: letters, digits, '_' and '-', 1 to 64 of them
    std::string body;  // JSON, of a change
    WebRole role = WebRole::viewer;
};

struct WebAnswer {
    int status = 200;
    std::string type = "text/plain";  // MIME type
    std::string body;
};

using WebAnswerer = std::function<WebAnswer(const WebQuestion&)>;

}  // namespace roomfix
