#include "roomfix/site/edit_site.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <chrono>
#include <fstream>
#include <sstream>

#include "roomfix/site/site_text.hpp"

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

/// Behind the last line of a block whose first key stands at `begin`: up to the next line that is indented less.
std::size_t end_of_block(std::string_view text, std::size_t begin, int column) {
    std::size_t end = std::min(text.find('\n', begin), text.size());
    for (std::size_t line = end + 1; line < text.size();) {
        const std::size_t next = std::min(text.find('\n', line), text.size());
        const std::size_t first = text.find_first_not_of(" \t\r", line);
        const bool empty = first == std::string_view::npos || first >= next;
        if (!empty && text[first] != '#' && static_cast<int>(first - line) < column) break;
        if (!empty && static_cast<int>(first - line) >= column) end = next;
        line = next + 1;
    }
    return end;
}

}  // namespace

Result<std::string> with_mount(std::string_view text, const std::string& camera, const Mount& mount) {
    try {
        const YAML::Node root = YAML::Load(std::string(text));
        const YAML::Node value = root["cameras"][camera]["mount"];
        if (!value.IsDefined()) return Error{fmt::format("the file has no cameras.{}.mount to write to", camera)};
        const auto begin = static_cast<std::size_t>(value.Mark().pos);
        if (begin >= text.size()) return Error{fmt::format("cameras.{}.mount cannot be found in the file", camera)};
        const bool braces = text[begin] == '{';
        const std::size_t end = braces ? end_of_braces(text, begin) : end_of_block(text, begin, value.Mark().column);
        std::string changed(text.substr(0, begin));
        if (!braces) {  // a block: its value goes up beside the key
            while (!changed.empty() && (changed.back() == ' ' || changed.back() == '\n' || changed.back() == '\r')) changed.pop_back();
            changed += ' ';
        }
        changed += mount_text(mount);
        changed += text.substr(end);
        return changed;
    } catch (const YAML::Exception& problem) {
        return Error{"not valid YAML: " + problem.msg};
    }
}

Result<std::filesystem::path> write_mount(const std::filesystem::path& file, const std::string& camera, const Mount& mount) {
    std::ifstream stream(file, std::ios::binary);
    std::ostringstream text;
    if (!stream || !(text << stream.rdbuf())) return Error{fmt::format("{}: cannot be read", file.string())};
    const auto changed = with_mount(text.str(), camera, mount);
    if (!changed) return Error{fmt::format("{}: {}", file.string(), changed.error().message)};
    const auto write = [](const std::filesystem::path& target, const std::string& content) {
        std::ofstream out(target, std::ios::binary);
        out << content;
        return static_cast<bool>(out.flush());
    };
    const auto now = std::chrono::time_point_cast<std::chrono::seconds>(std::chrono::system_clock::now());
    const std::filesystem::path copy = fmt::format("{}.{:%Y%m%d-%H%M%S}", file.string(), fmt::gmtime(now));
    const std::filesystem::path fresh = file.string() + ".new";
    std::error_code failure;
    if (write(copy, text.str()) && write(fresh, *changed))
        std::filesystem::rename(fresh, file, failure);
    else
        failure = std::make_error_code(std::errc::io_error);
    if (failure) return Error{fmt::format("{}: cannot be written: check the folder's permissions and room", file.string())};
    return copy;
}

}  // namespace roomfix
