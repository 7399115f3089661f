// Questions to the web server that somebody else answers.
#pragma once

#include <functional>
#include <map>
#include <string>

namespace roomfix {

using WebParameters = std::multimap<std::string, std::string>;  // of the address, behind the question mark, decoded

struct WebAnswer {
    int status = 200;
    std::string type = "text/plain";  // MIME type
    std::string body;
};

using WebAnswerer = std::function<WebAnswer(const WebParameters&)>;

}  // namespace roomfix
