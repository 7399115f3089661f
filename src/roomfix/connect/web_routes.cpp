#include "roomfix/connect/web_routes.hpp"

#include <algorithm>

namespace roomfix {
namespace {

constexpr std::size_t longest_id = 64;

bool is_id(std::string_view text) {
    const auto fits = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-'; };
    return !text.empty() && text.size() <= longest_id && std::all_of(text.begin(), text.end(), fits);
}

}  // namespace

std::optional<std::string> id_in(std::string_view path, std::string_view route) {
    const std::string_view pattern = route.substr(route.find(' ') + 1);
    const std::size_t hole = pattern.find("{id}");
    if (hole == std::string_view::npos) return path == pattern ? std::optional<std::string>("") : std::nullopt;
    const std::string_view before = pattern.substr(0, hole), after = pattern.substr(hole + 4);
    if (path.size() < before.size() + after.size() || !path.starts_with(before) || !path.ends_with(after)) return std::nullopt;
    const std::string_view id = path.substr(before.size(), path.size() - before.size() - after.size());
    return is_id(id) ? std::optional<std::string>(id) : std::nullopt;
}

}  // namespace roomfix
