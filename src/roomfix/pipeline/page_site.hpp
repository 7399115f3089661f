// What the page is told of the site: once, and again where it changes. Documented in docs/openapi.json.
#pragma once

#include <string>
#include <vector>

#include "roomfix/connect/plan_picture.hpp"
#include "roomfix/pipeline/site_tracker.hpp"

namespace roomfix {

/// The answer to /api/site. `zones`: those of now; `plan`: the picture of the site's plan, null where it has none.
std::string page_site_json(const SiteTracker& tracker, const std::vector<SiteZone>& zones, const PlanPicture* plan);

}  // namespace roomfix
