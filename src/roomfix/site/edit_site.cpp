#include "roomfix/site/edit_site.hpp"

#include <fcntl.h>
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>
#include <yaml-cpp/yaml.h>

#include <cerrno>
#include <chrono>

#include "roomfix/base/text_file.hpp"

namespace roomfix {
namespace {

/// Behind the brace that closes the one at `begin`; quotes and comments are passed over.
std::size_t end_of_braces(std::string_view text, std::size_t begin) {
    int depth = 0;
    for (std::size_t i = begin; i < text.size(); ++i) {
        const char c = text[i];
        if (c == '\'' || c == '"') {
            const auto end = text.find(c, i + 1);
            if (end == std::string_view::npos) break;
            i = end;
        } else if (c == '#' && i > 0 && (text[i - 1] == ' ' || text[i - 1] == '\n')) {
            i = std::min(text.find('\n', i), text.size() - 1);
        } else if (c == '{' || c == '[') {
            ++depth;
        } else if ((c == '}' || c == ']') && --depth == 0) {
            return i + 1;
        }
    }
    return text.size();
}

/// Behind the last line of a block whose first key or dash stands at `begin`: up to the next line that is indented less, or, behind a list that is indented
/// like its own key, up to the next key.
std::size_t end_of_block(std::string_view text, std::size_t begin, int column) {
    std::size_t end = std::min(text.find('\n', begin), text.size());
    for (std::size_t line = end + 1; line < text.size();) {
        const std::size_t next = std::min(text.find('\n', line), text.size());
        const std::size_t first = text.find_first_not_of(" \t\r", line);
        const bool empty = first == std::string_view::npos || first >= next;
        const bool beside = !empty && static_cast<int>(first - line) == column && text[begin] == '-' && text[first] != '-';
        if (!empty && text[first] != '#' && (static_cast<int>(first - line) < column || beside)) break;
        if (!empty && static_cast<int>(first - line) >= column) end = next;
        line = next + 1;
    }
    return end;
}

/// Behind a scalar that begins at `begin`; `flow`: within braces.
std::size_t end_of_scalar(std::string_view text, std::size_t begin, bool flow) {
    const char quote = text[begin];
    if (quote == '\'' || quote == '"') {
        const auto end = text.find(quote, begin + 1);
        return end == std::string_view::npos ? text.size() : end + 1;
    }
    std::size_t end = begin;
    for (; end < text.size() && text[end] != '\n' && text[end] != '\r'; ++end) {
        if (text[end] == '#' && end > begin && text[end - 1] == ' ') break;
        if (flow && (text[end] == ',' || text[end] == '}')) break;
    }
    while (end > begin && text[end - 1] == ' ') --end;
    return end;
}

/// A key of a map and the stretch of text that it and its value take.
struct Entry {
    std::size_t key = 0, value = 0, end = 0;
    bool block = false;  // its value is on lines of its own
};

Entry entry_of(std::string_view text, const YAML::Node& key, const YAML::Node& value, bool flow) {
    Entry entry;
    entry.key = static_cast<std::size_t>(key.Mark().pos);
    entry.value = std::min(static_cast<std::size_t>(value.Mark().pos), text.size() - 1);
    entry.block = !value.IsScalar() && text[entry.value] != '{' && text[entry.value] != '[';
    if (value.IsScalar()) {
        entry.end = end_of_scalar(text, entry.value, flow);
    } else {
        entry.end = entry.block ? end_of_block(text, entry.value, value.Mark().column) : end_of_braces(text, entry.value);
    }
    return entry;
}

/// All keys of a map, in their order in the file.
std::vector<std::pair<std::string, Entry>> entries_of(std::string_view text, const YAML::Node& map, bool flow) {
    std::vector<std::pair<std::string, Entry>> entries;
    for (const auto& item : map) entries.emplace_back(item.first.Scalar(), entry_of(text, item.first, item.second, flow));
    return entries;
}

std::string replaced(std::string_view text, const Entry& entry, const std::string& value) {
    std::string changed(text.substr(0, entry.value));
    // A block's value goes up beside its key, unless a comment stands there.
    const bool comment = text.substr(entry.key, entry.value - entry.key).find('#') != std::string_view::npos;
    while (entry.block && !comment && (changed.back() == ' ' || changed.back() == '\n' || changed.back() == '\r')) changed.pop_back();
    if (entry.block && !comment) changed += ' ';
    return changed + value + std::string(text.substr(entry.end));
}

std::string removed(std::string_view text, const Entry& entry, bool flow) {
    std::size_t from = entry.key, to = entry.end;
    if (flow) {
        const std::size_t next = text.find_first_not_of(" \n\r\t", to);
        if (next != std::string_view::npos && text[next] == ',') {
            to = std::min(text.find_first_not_of(" \n\r\t", next + 1), text.size());
        } else {
            from = text.find_last_of(",{", from - 1);
            if (text[from] == '{') ++from;
        }
    } else {
        from = text.rfind('\n', from) + 1;  // npos + 1 is the beginning
        to = std::min(text.find('\n', to), text.size() - 1) + 1;
    }
    return std::string(text.substr(0, from)) + std::string(text.substr(to));
}

std::string added(std::string_view text, const Entry& last, int column, const SiteValue& value, bool flow) {
    if (flow) return std::string(text.substr(0, last.end)) + fmt::format(", {}: {}", value.key, value.value) + std::string(text.substr(last.end));
    const std::size_t line_end = std::min(text.find('\n', last.end), text.size());
    return std::string(text.substr(0, line_end)) + fmt::format("\n{:{}}{}: {}", "", column, value.key, value.value) + std::string(text.substr(line_end));
}

/// A map that has keys with one of them replaced, added or removed.
std::string with_key(const std::string& text, const YAML::Node& map, const SiteValue& value) {
    const bool flow = map.Style() == YAML::EmitterStyle::Flow;
    const auto entries = entries_of(text, map, flow);
    for (const auto& [key, entry] : entries) {
        if (key == value.key) return value.value.empty() ? removed(text, entry, flow) : replaced(text, entry, value.value);
    }
    if (value.value.empty()) return text;
    return added(text, entries.back().second, map.begin()->first.Mark().column, value, flow);
}

/// One change; the text is read anew for each, since places move.
Result<std::string> with_value(const std::string& text, const SiteEdit& edit, const SiteValue& value) {
    const YAML::Node map = YAML::Load(text)[edit.section][edit.id];
    if (!map.IsDefined() || !map.IsMap() || map.size() == 0) return Error{fmt::format("the file has no {}.{} to write to", edit.section, edit.id)};
    return with_key(text, map, value);
}

bool is_flow(const YAML::Node& map) { return map.Style() == YAML::EmitterStyle::Flow; }

/// A section that is not there yet, or empty, with its first entry.
std::string with_section(std::string text, const YAML::Node& root, const std::string& section, const SiteValue& entry) {
    const bool one_line = is_flow(root) || root[section].IsDefined();
    if (one_line) return with_key(text, root, {section, fmt::format("{{{}: {}}}", entry.key, entry.value)});
    if (!text.ends_with('\n')) text += '\n';
    return text + fmt::format("{}:\n  {}: {}\n", section, entry.key, entry.value);
}

}  // namespace

Result<std::string> with_values(std::string_view text, const SiteEdit& edit) {
    try {
        std::string changed(text);
        for (const SiteValue& value : edit.values) {
            auto next = with_value(changed, edit, value);
            if (!next) return next;
            changed = std::move(*next);
        }
        return changed;
    } catch (const YAML::Exception& problem) {
        return Error{"not valid YAML: " + problem.msg};
    }
}

Result<std::string> with_entry(std::string_view before, const std::string& section, const SiteValue& entry) {
    try {
        const std::string text(before);
        const YAML::Node root = YAML::Load(text);
        if (!root.IsMap() || root.size() == 0) return Error{"the file is no map with keys"};
        const YAML::Node map = root[section];
        const bool filled = map.IsDefined() && map.IsMap() && map.size() > 0;
        if (!filled) return entry.value.empty() ? text : with_section(text, root, section, entry);
        if (entry.value.empty() && map.size() == 1 && map[entry.key].IsDefined()) return without_section(text, section);
        return with_key(text, map, entry);
    } catch (const YAML::Exception& problem) {
        return Error{"not valid YAML: " + problem.msg};
    }
}

Result<std::string> without_section(std::string_view text, const std::string& key) {
    try {
        const YAML::Node root = YAML::Load(std::string(text));
        const bool flow = root.IsMap() && root.Style() == YAML::EmitterStyle::Flow;
        for (const auto& [name, entry] : entries_of(text, root, flow)) {
            if (name == key) return removed(text, entry, flow);
        }
        return std::string(text);
    } catch (const YAML::Exception& problem) {
        return Error{"not valid YAML: " + problem.msg};
    }
}

/// Written through to the disk, so that a machine that loses its power has the old file or the new one.
static bool write_through(const std::filesystem::path& target, const std::string& content, mode_t mode) {
    const int file = ::open(target.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, mode);
    if (file < 0) return false;
    bool written = ::fchmod(file, mode) == 0;
    for (std::size_t at = 0; written && at < content.size();) {
        const ssize_t count = ::write(file, content.data() + at, content.size() - at);
        if (count > 0) at += static_cast<std::size_t>(count);
        written = count > 0 || (count < 0 && errno == EINTR);
    }
    written = written && ::fsync(file) == 0;
    return ::close(file) == 0 && written;
}

Result<void> replace_file(const std::filesystem::path& named, const std::string& text, const std::filesystem::path& copy) {
    std::error_code failure;
    const std::filesystem::path file = std::filesystem::canonical(named, failure);  // what a link leads to
    const auto before = failure ? Result<std::string>(Error{named.string() + ": cannot be read"}) : read_text(file);
    if (!before) return before.error();
    struct stat about = {};
    const mode_t mode = ::stat(file.c_str(), &about) == 0 ? about.st_mode & 07777 : 0600;
    const std::filesystem::path fresh = file.string() + ".new";
    if (write_through(copy, *before, mode) && write_through(fresh, text, mode)) {
        std::filesystem::rename(fresh, file, failure);
    } else {
        failure = std::make_error_code(std::errc::io_error);
    }
    if (!failure) return {};
    std::error_code ignored;
    std::filesystem::remove(fresh, ignored);
    return Error{fmt::format("{}: cannot be written: check the folder's permissions and room", file.string())};
}

Result<std::filesystem::path> write_site_values(const std::filesystem::path& file, const std::vector<SiteEdit>& edits) {
    const auto text = read_text(file);
    if (!text) return text.error();
    auto changed = text;
    for (const SiteEdit& edit : edits) {
        changed = with_values(*changed, edit);
        if (!changed) return Error{fmt::format("{}: {}", file.string(), changed.error().message)};
    }
    const auto now = std::chrono::time_point_cast<std::chrono::seconds>(std::chrono::system_clock::now());
    const std::filesystem::path copy = fmt::format("{}.{:%Y%m%d-%H%M%S}", file.string(), fmt::gmtime(now));
    if (const auto replaced = replace_file(file, *changed, copy); !replaced) return replaced.error();
    return copy;
}

}  // namespace roomfix
