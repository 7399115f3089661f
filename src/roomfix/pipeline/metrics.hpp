// How a running site fares, as Prometheus reads it.
#pragma once

#include <string>
#include <vector>

#include "roomfix/pipeline/fix_sink.hpp"
#include "roomfix/pipeline/site_tracker.hpp"

namespace roomfix {

/// Text exposition format 0.0.4. `robots`: the newest fix of each. Names and units: docs/formats.md.
std::string metrics_text(const SiteTracker& tracker, const std::vector<Fix>& robots, const std::vector<SinkState>& sinks);

}  // namespace roomfix
