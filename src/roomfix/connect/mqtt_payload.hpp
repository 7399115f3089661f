// What is said about robots on MQTT, as in docs/formats.md.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "roomfix/observation/fix.hpp"

namespace roomfix {

/// A name as one word of a topic: everything but letters, digits, - and _ becomes _.
std::string topic_word(const std::string& name);

/// A fix that has a place, as one JSON object.
std::string pose_payload(const Fix& fix);
/// That a robot entered or left a zone, as one JSON object.
std::string zone_payload(Nanoseconds time, const std::string& robot, bool entered);

/// What Home Assistant has to be told about a robot: topics below "homeassistant/", each with its configuration.
/// `topics`: PREFIX/SITE. `node`: a word that no other roomfix uses.
std::vector<std::pair<std::string, std::string>> home_assistant_discovery(const std::string& topics, const std::string& node, const std::string& robot);

}  // namespace roomfix
