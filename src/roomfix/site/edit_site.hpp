// Changes single values of a site file in place; comments, order and everything else stay.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "roomfix/base/result.hpp"

namespace roomfix {

/// A key of a camera or a robot and its new value as YAML on one line; without a value the key goes.
struct SiteValue {
    std::string key;
    std::string value;
};

struct SiteEdit {
    std::string id;
    std::vector<SiteValue> values;
    std::string section = "cameras";  // or "robots"
};

/// The text of a site file with keys of SECTION.ID replaced, added after the others, or removed. An error if there is nothing of that id.
Result<std::string> with_values(std::string_view text, const SiteEdit& edit);

/// The text without one of the keys of the file itself, such as `outputs`, and all that is under it.
Result<std::string> without_section(std::string_view text, const std::string& key);

/// Changes a file's values, several times. The file as it was is kept beside it, its name followed by the date and time; returns that name.
/// Nothing is changed unless all of it can be written.
Result<std::filesystem::path> write_site_values(const std::filesystem::path& file, const std::vector<SiteEdit>& edits);

}  // namespace roomfix
