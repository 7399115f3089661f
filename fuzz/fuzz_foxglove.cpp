// Any bytes as a request of a Foxglove client.
#include <cstddef>
#include <cstdint>

#include "roomfix/connect/foxglove_request.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    constexpr std::size_t channels = 7;
    const auto request = roomfix::parse_foxglove_request({reinterpret_cast<const char*>(data), size}, channels);
    for (const auto& wish : request.subscribe) {
        if (wish.channel < 1 || wish.channel > channels) __builtin_trap();
    }
    for (const auto& problem : request.problems) {
        if (problem.empty()) __builtin_trap();
    }
    return 0;
}
