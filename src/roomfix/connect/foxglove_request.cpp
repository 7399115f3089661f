#include "roomfix/connect/foxglove_request.hpp"

#include <fmt/format.h>

#include <limits>
#include <nlohmann/json.hpp>
#include <optional>

namespace roomfix {
namespace {

using nlohmann::json;

/// A whole number of 32 bits that is not negative; nothing else is one.
std::optional<std::uint32_t> number_of(const json& value) {
    constexpr std::uint64_t largest = std::numeric_limits<std::uint32_t>::max();
    if (!value.is_number_unsigned() || value.get<std::uint64_t>() > largest) return std::nullopt;
    return value.get<std::uint32_t>();
}

json member_of(const json& value, const char* name) { return value.is_object() && value.contains(name) ? value.at(name) : json(); }

/// The list of this name; empty where there is none.
json list_in(const json& value, const char* name) {
    json list = member_of(value, name);
    return list.is_array() ? list : json::array();
}

void read_subscription(const json& wish, std::size_t channels, FoxgloveRequest& request) {
    const auto id = number_of(member_of(wish, "id"));
    const auto channel = number_of(member_of(wish, "channelId"));
    if (!id || !channel) {
        request.problems.emplace_back("a subscription has an id and a channelId");
    } else if (*channel < 1 || *channel > channels) {
        request.problems.push_back(fmt::format("there is no channel {}", *channel));
    } else {
        request.subscribe.push_back({*id, *channel});
    }
}

}  // namespace

FoxgloveRequest parse_foxglove_request(std::string_view text, std::size_t channels) {
    FoxgloveRequest request;
    const json wish = json::parse(text, nullptr, false);
    const json operation = member_of(wish, "op");
    if (operation == "subscribe") {
        for (const json& one : list_in(wish, "subscriptions")) read_subscription(one, channels, request);
    } else if (operation == "unsubscribe") {
        for (const json& one : list_in(wish, "subscriptionIds")) {
            if (const auto id = number_of(one)) request.unsubscribe.push_back(*id);
        }
    } else {
        request.problems.emplace_back(operation.is_string() ? "this server only knows subscribe and unsubscribe" : "a request is a JSON object with \"op\"");
    }
    return request;
}

}  // namespace roomfix
