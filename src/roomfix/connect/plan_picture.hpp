// The picture of a site's plan.
#pragma once

#include <string>

#include "roomfix/base/result.hpp"
#include "roomfix/site/site.hpp"

namespace roomfix {

struct PlanPicture {
    int width = 0, height = 0;  // px
    std::string png;
};

/// Decoded whole, so that a damaged file is an error now. A PNG stays as it is, other pictures become one; those whose map file says `negate` are turned over:
/// what is occupied is dark.
Result<PlanPicture> load_plan_picture(const Site& site, const SitePlan& plan);

}  // namespace roomfix
