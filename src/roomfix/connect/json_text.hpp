// Values of JSON as text, to be read like CSV's fields.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace roomfix {

/// A string's content, a number's digits; empty where there is nothing.
inline std::string json_text(const nlohmann::json& json, const char* key) {
    const auto found = json.find(key);
    if (found == json.end() || found->is_null()) return "";
    return found->is_string() ? found->get<std::string>() : found->dump();
}

/// One line of JSON. Bytes that are no UTF-8 are replaced: they come from other programs' messages, and must not cost more than themselves.
template <class Json>
std::string json_line(const Json& json) {
    return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace roomfix
