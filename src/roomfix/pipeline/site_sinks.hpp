// The sinks that a site file asks for.
#pragma once

#include "roomfix/pipeline/source_runner.hpp"

namespace roomfix {

/// All of `outputs` but the page and the file of fixes. An error where one's settings cannot work. `overflow`: where they cannot keep up. `tell` gets
/// sentences about peers that vanish and come back, from other threads.
Result<void> add_site_sinks(SourceRunner& runner, SiteTracker& tracker, Overflow overflow, const std::function<void(const std::string&)>& on_trouble);

}  // namespace roomfix
