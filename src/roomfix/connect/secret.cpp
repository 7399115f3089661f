#include "roomfix/connect/secret.hpp"

#include <fmt/format.h>

#include <cstdlib>
#include <fstream>

namespace roomfix {

Result<std::string> secret_text(const Secret& secret, const Site& site, const std::string& what) {
    if (secret.file.empty()) {
        const char* value = std::getenv(secret.variable.c_str());
        if (value && *value) return std::string(value);
        return Error{fmt::format("{} is not there: the environment has no variable {}", what, secret.variable)};
    }
    const std::string file = resolved_path(site, secret.file);
    std::ifstream stream(file);
    std::string line;
    if (!std::getline(stream, line)) return Error{fmt::format("{}: {} is to be its first line, but it cannot be read or is empty", file, what)};
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (line.empty()) return Error{fmt::format("{}: {} is to be its first line, but that is empty", file, what)};
    return line;
}

}  // namespace roomfix
