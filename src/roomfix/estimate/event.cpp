#include "roomfix/estimate/event.hpp"

namespace roomfix {

int robot_of(const Event& event) {
    return std::visit(
        [](const auto& what) {
            if constexpr (std::is_same_v<std::decay_t<decltype(what)>, GroupSighting>)
                return -1;
            else
                return what.robot;
        },
        event.what);
}

}  // namespace roomfix
