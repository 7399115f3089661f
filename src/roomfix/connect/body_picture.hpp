// A picture of a learned body for people to check.
#pragma once

#include <filesystem>

#include "roomfix/base/result.hpp"
#include "roomfix/site/learned_body.hpp"

namespace roomfix {

/// Writes the body as it is seen from the front, the left, the back, the right and from above, with its size, as PNG or JPEG.
Result<void> save_body_picture(const std::filesystem::path& file, const LearnedBody& body);

}  // namespace roomfix
