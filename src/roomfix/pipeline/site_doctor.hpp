// Tries everything that a site file names: what is wrong before `run`, and what to do.
#pragma once

#include <functional>
#include <string>

#include "roomfix/site/site.hpp"

namespace roomfix {

struct Finding {
    enum class Kind { fine, note, problem };
    Kind kind = Kind::fine;
    std::string what;  // "camera hall", "MQTT at broker:1883"
    std::string text;  // what was found; of a problem: what to do
};

/// Cameras are looked through for a second or two each, brokers and databases are called, addresses to listen at are taken for a moment. `found` gets each
/// finding as soon as it is made.
void examine(const Site& site, const std::function<void(const Finding&)>& found);

}  // namespace roomfix
