// The codes of a family of tags, as libapriltag wants them.
#pragma once

#include <memory>

#include "roomfix/base/tag_family.hpp"

extern "C" {
#include <apriltag/apriltag.h>
}

namespace roomfix {

using TagCodes = std::unique_ptr<apriltag_family_t, void (*)(apriltag_family_t*)>;

/// Null where this build cannot read the family.
TagCodes tag_codes(TagFamily family);

}  // namespace roomfix
