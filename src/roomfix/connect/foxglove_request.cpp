#include "roomfix/connect/foxglove_request.hpp"

#include <fmt/format.h>

#include <limits>
#include <nlohmann/json.hpp>
#include <optional>

namespace roomfix {
namespace {

using nlohmann::json;

/// A whole number that is not negative and not above `most`; nothing else is one.
std::optional<std::uint64_t> number_in(const json& value, std::uint64_t most) {
    if (!value.is_number_unsigned() || value.get<std::uint64_t>() > most) return std::nullopt;
    return value.get<std::uint64_t>();
}

/// The list of this name; empty where there is none.
json list_in(const json& object, const char* name) {
    const auto found = object.find(name);
    return found != object.end() && found->is_array() ? *found : json::array();
}

json member_of(const json& value, const char* name) { return value.is_object() && value.contains(name) ? value.at(name) : json(); }

constexpr std::uint64_t largest_id = std::numeric_limits<std::uint32_t>::max();

void read_subscription(const json& wish, std::size_t channels, FoxgloveRequest& request) {
    const auto id = number_in(member_of(wish, "id"), largest_id);
    const auto channel = number_in(member_of(wish, "channelId"), largest_id);
    if (!id || !channel) {
        request.problems.emplace_back("a subscription has an id and a channelId");
    } else if (*channel < 1 || *channel > channels) {
        request.problems.push_back(fmt::format("there is no channel {}", *channel));
    } else {
        request.subscribe.push_back({static_cast<std::uint32_t>(*id), static_cast<std::size_t>(*channel)});
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
            if (const auto id = number_in(one, largest_id)) request.unsubscribe.push_back(static_cast<std::uint32_t>(*id));
        }
    } else {
        request.problems.emplace_back(operation.is_string() ? "this server only knows subscribe and unsubscribe" : "a request is a JSON object with \"op\"");
    }
    return request;
}

}  // namespace roomfix
