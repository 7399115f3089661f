// What a client of Foxglove's WebSocket protocol asks for.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace roomfix {

struct FoxgloveRequest {
    struct Subscription {
        std::uint32_t id = 0;     // as the client calls it
        std::size_t channel = 0;  // counted from 1
    };
    std::vector<Subscription> subscribe;
    std::vector<std::uint32_t> unsubscribe;
    std::vector<std::string> problems;  // for the client
};

/// Of `channels` channels. Of what is wrong the problems are told; the rest is taken.
FoxgloveRequest parse_foxglove_request(std::string_view text, std::size_t channels);

}  // namespace roomfix
