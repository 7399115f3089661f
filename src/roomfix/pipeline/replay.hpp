// A recorded session gone through as fast as it goes: its fixes, and the tracker that gave them.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "roomfix/pipeline/background_source.hpp"
#include "roomfix/pipeline/site_tracker.hpp"

namespace roomfix {

struct ReplaySettings {
    int threads = 1;                          // that look at frames; the fixes do not depend on it
    std::vector<std::string> background;      // sources for all fixed cameras; empty: what the site says of each
    bool keep_history = false;                // what smooth() needs, and all that learns from a whole session
    const std::atomic<bool>* stop = nullptr;  // set by somebody else to end it early
    std::function<void(double)> progress;     // gets 0..1; may be empty
    BackgroundListener listener;              // of the backgrounds that are learned before
};

struct Replayed {
    std::unique_ptr<SiteTracker> tracker;
    std::vector<Fix> fixes;  // in the order in which they were given
};

/// The same session gives the same fixes. An error where a source cannot be opened or a background not be learned.
Result<Replayed> replay(const Site& site, const ReplaySettings& settings = {});

}  // namespace roomfix
