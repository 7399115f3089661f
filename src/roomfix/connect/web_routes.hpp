// What the web server can be asked. docs/openapi.json describes each of them, and a test compares the two.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

namespace roomfix {

constexpr std::array<std::string_view, 13> web_routes = {
    "GET /api/access",       "GET /api/cameras/{id}.jpg", "GET /api/events",      "GET /api/history", "GET /api/history/zones",
    "GET /api/openapi.json", "GET /api/plan.png",         "GET /api/robots/{id}", "GET /api/site",    "GET /api/state",
    "PUT /api/zones/{id}",   "DELETE /api/zones/{id}",    "GET /metrics",
};

/// What stands in a path for a route's {id} (letters, digits, '_' and '-', 1 to 64 of them), empty where the route has none; nothing where the path is of
/// another route.
std::optional<std::string> id_in(std::string_view path, std::string_view route);

}  // namespace roomfix
