// What the page is told of the site: once, and again where it changes. Documented in docs/openapi.json.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "roomfix/connect/plan_picture.hpp"
#include "roomfix/pipeline/site_tracker.hpp"

namespace roomfix {

/// What changes of it, and goes with it.
struct PageSite {
    std::int64_t version = 0;  // another one whenever anything changes
    std::vector<SiteZone> zones;
    const PlanPicture* plan = nullptr;  // of the site's plan; null: it has none
};

/// The answer to /api/site.
std::string page_site_json(const SiteTracker& tracker, const PageSite& now);

}  // namespace roomfix
