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

/// The text with an entry of a section of the file, such as a zone of `zones`, replaced, added after the others, or, without a value, removed. A section that
/// is not there is added at the end, one that would be empty goes. An error where the text is no YAML.
Result<std::string> with_entry(std::string_view text, const std::string& section, const SiteValue& entry);

/// The text without one of the keys of the file itself, such as `outputs`, and all that is under it.
Result<std::string> without_section(std::string_view text, const std::string& key);

/// Gives a file another content, all of it or nothing; its mode stays, and a link leads to it as before. `copy` gets the file as it was.
Result<void> replace_file(const std::filesystem::path& file, const std::string& text, const std::filesystem::path& copy);

/// Changes a file's values, several times. The file as it was is kept beside it, its name followed by the date and time; returns that name.
/// Nothing is changed unless all of it can be written.
Result<std::filesystem::path> write_site_values(const std::filesystem::path& file, const std::vector<SiteEdit>& edits);

}  // namespace roomfix
