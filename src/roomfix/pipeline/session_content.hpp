// What a session has beside what comes while it is recorded: the site file, backgrounds, learned bodies, lens grids.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "roomfix/connect/session_writer.hpp"
#include "roomfix/pipeline/site_tracker.hpp"

namespace roomfix {

/// For a session of `tracker`. `site_file` is what its site was loaded from: its text stays as it is but for what lies elsewhere in a session, and for the
/// outputs, which a replay must not feed. `background` for all cameras, as it was given to learn_backgrounds(). An error if a file cannot be read.
Result<SessionContent> session_content(const SiteTracker& tracker, const std::filesystem::path& site_file, const std::vector<std::string>& background);

}  // namespace roomfix
