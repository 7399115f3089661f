#include "roomfix/site/yaml_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "roomfix/base/number.hpp"
#include "roomfix/base/printable.hpp"

namespace roomfix {
namespace {

constexpr double farthest = 1e5;  // m or px: no coordinate of a site is larger

/// Levenshtein distance, for "did you mean".
std::size_t edit_distance(const std::string& a, const std::string& b) {
    std::vector<std::size_t> row(b.size() + 1);
    for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
    for (std::size_t i = 1; i <= a.size(); ++i) {
        std::size_t diagonal = row[0];
        row[0] = i;
        for (std::size_t j = 1; j <= b.size(); ++j) {
            const std::size_t up = row[j];
            row[j] = std::min({row[j] + 1, row[j - 1] + 1, diagonal + (a[i - 1] != b[j - 1])});
            diagonal = up;
        }
    }
    return row[b.size()];
}

std::string suggestion(const std::string& key, std::initializer_list<const char*> known) {
    if (key.size() > 40) return fmt::format("known here: {}", fmt::join(known, ", "));
    for (const char* candidate : known) {
        if (edit_distance(key, candidate) <= 1 + key.size() / 4) return fmt::format("did you mean '{}'?", candidate);
    }
    return fmt::format("known here: {}", fmt::join(known, ", "));
}

std::string shown(const YAML::Node& node) {
    if (node.IsMap()) return "a map";
    if (node.IsSequence()) return "a list";
    if (!node.IsScalar()) return "nothing";
    const std::string& text = node.Scalar();
    return text.size() > 40 ? fmt::format("'{}...'", text.substr(0, 40)) : fmt::format("'{}'", text);
}

}  // namespace

void YamlReader::add(const YAML::Node& at, bool fatal, const std::string& message) {
    const YAML::Mark mark = at.IsDefined() ? at.Mark() : YAML::Mark::null_mark();
    problems_.push_back({mark.line + 1, mark.column + 1, fatal, printable(message)});
}

bool YamlReader::map(const YAML::Node& node, const std::string& what, std::initializer_list<const char*> known) {
    if (!node.IsMap()) {
        error(node, fmt::format("{} must be a map with the keys {}, not {}", what, fmt::join(known, ", "), shown(node)));
        return false;
    }
    std::vector<std::string> seen;
    for (const auto& entry : node) {
        const std::string key = entry.first.IsScalar() ? entry.first.Scalar() : shown(entry.first);
        if (std::find(known.begin(), known.end(), key) == known.end()) {
            error(entry.first, fmt::format("{} has no key '{}': {}", what, key.substr(0, 40), suggestion(key, known)));
        } else if (std::find(seen.begin(), seen.end(), key) != seen.end()) {
            error(entry.first, fmt::format("'{}' is given twice in {}: keep one", key, what));
        }
        seen.push_back(key);
    }
    return true;
}

std::vector<std::pair<std::string, YAML::Node>> YamlReader::named(const YAML::Node& node, const std::string& what) {
    std::vector<std::pair<std::string, YAML::Node>> entries;
    if (!node.IsDefined() || node.IsNull()) return entries;
    if (!node.IsMap()) {
        error(node, fmt::format("{} must be a map of names, not {}", what, shown(node)));
        return entries;
    }
    for (const auto& entry : node) {
        const std::string id = entry.first.IsScalar() ? entry.first.Scalar() : "";
        const bool plain = !id.empty() && id.size() <= 64 &&
                           std::all_of(id.begin(), id.end(), [](unsigned char c) { return c < 128 && (std::isalnum(c) || c == '_' || c == '-'); });
        if (!plain) {
            error(entry.first, fmt::format("a name in {} may have letters, digits, '_' and '-' only (at most 64), not {}", what, shown(entry.first)));
            continue;
        }
        const bool taken = std::any_of(entries.begin(), entries.end(), [&](const auto& e) { return e.first == id; });
        if (taken) {
            error(entry.first, fmt::format("'{}' stands twice in {}: give each its own name", id, what));
            continue;
        }
        entries.emplace_back(id, entry.second);
    }
    return entries;
}

YAML::Node YamlReader::required(const YAML::Node& parent, const char* key, const std::string& what) {
    const YAML::Node value = parent[key];
    if (!value.IsDefined()) error(parent, fmt::format("{} needs the key '{}'", what, key));
    return value;
}

std::optional<double> YamlReader::number(const YAML::Node& node, const std::string& what, double least, double most) {
    if (!node.IsDefined()) return std::nullopt;
    const auto value = node.IsScalar() ? parse_number(node.Scalar()) : std::nullopt;
    if (!value) {
        error(node, fmt::format("{} must be a number, not {}", what, shown(node)));
        return std::nullopt;
    }
    if (*value < least || *value > most) {
        error(node, fmt::format("{} must lie between {:g} and {:g}, not {}", what, least, most, shown(node)));
        return std::nullopt;
    }
    return value;
}

std::optional<int> YamlReader::integer(const YAML::Node& node, const std::string& what, int least, int most) {
    const auto value = number(node, what, least, most);
    if (value && *value != std::floor(*value)) {
        error(node, fmt::format("{} must be a whole number, not {}", what, shown(node)));
        return std::nullopt;
    }
    if (!value) return std::nullopt;
    return static_cast<int>(*value);
}

std::optional<std::string> YamlReader::text(const YAML::Node& node, const std::string& what) {
    if (!node.IsDefined()) return std::nullopt;
    if (!node.IsScalar() || node.Scalar().empty()) {
        error(node, fmt::format("{} must be a text, not {}", what, shown(node)));
        return std::nullopt;
    }
    return node.Scalar();
}

bool YamlReader::list(const YAML::Node& node, const std::string& what) {
    if (node.IsDefined() && node.IsSequence()) return true;
    if (node.IsDefined()) error(node, fmt::format("{} must be a list, not {}", what, shown(node)));
    return false;
}

std::optional<std::vector<double>> YamlReader::numbers(const YAML::Node& node, const std::string& what, std::size_t count, double least, double most) {
    if (!node.IsDefined()) return std::nullopt;
    if (!node.IsSequence() || node.size() != count) {
        error(node,
              fmt::format("{} must be a list of {} numbers, not {}", what, count, node.IsSequence() ? fmt::format("{} of them", node.size()) : shown(node)));
        return std::nullopt;
    }
    std::vector<double> values;
    for (const auto& item : node) {
        if (const auto value = number(item, what, least, most)) values.push_back(*value);
    }
    if (values.size() != count) return std::nullopt;
    return values;
}

std::optional<Eigen::Vector2d> YamlReader::point2(const YAML::Node& node, const std::string& what) {
    const auto v = numbers(node, what, 2, -farthest, farthest);
    if (!v) return std::nullopt;
    return Eigen::Vector2d((*v)[0], (*v)[1]);
}

std::optional<Eigen::Vector3d> YamlReader::point3(const YAML::Node& node, const std::string& what) {
    const auto v = numbers(node, what, 3, -farthest, farthest);
    if (!v) return std::nullopt;
    return Eigen::Vector3d((*v)[0], (*v)[1], (*v)[2]);
}

}  // namespace roomfix
