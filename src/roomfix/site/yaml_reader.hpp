// Reads YAML into plain values and collects every problem with its place instead of stopping at the first.
#pragma once

#include <yaml-cpp/yaml.h>

#include <Eigen/Core>
#include <initializer_list>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "roomfix/site/load_site.hpp"

namespace roomfix {

class YamlReader {
public:
    explicit YamlReader(std::vector<Problem>& problems) : problems_(problems) {}

    void error(const YAML::Node& at, std::string message) { add(at, true, std::move(message)); }
    void warn(const YAML::Node& at, std::string message) { add(at, false, std::move(message)); }

    /// False, with a problem, unless `node` is a map. Reports keys that are not in `known` and keys given twice.
    bool map(const YAML::Node& node, const std::string& what, std::initializer_list<const char*> known);
    /// The entries of a map of named things, in the order of the file; reports names that cannot be an id, or are taken.
    std::vector<std::pair<std::string, YAML::Node>> named(const YAML::Node& node, const std::string& what);

    /// The value of a key, or an undefined node with a problem reported at the parent.
    YAML::Node required(const YAML::Node& parent, const char* key, const std::string& what);

    std::optional<double> number(const YAML::Node& node, const std::string& what, double least, double most);
    std::optional<int> integer(const YAML::Node& node, const std::string& what, int least, int most);
    std::optional<std::string> text(const YAML::Node& node, const std::string& what);
    /// A list of `count` numbers within the limits.
    std::optional<std::vector<double>> numbers(const YAML::Node& node, const std::string& what, std::size_t count, double least, double most);
    std::optional<Eigen::Vector2d> point2(const YAML::Node& node, const std::string& what);
    std::optional<Eigen::Vector3d> point3(const YAML::Node& node, const std::string& what);
    /// A list of any length; an empty optional with a problem if it is none.
    bool list(const YAML::Node& node, const std::string& what);

private:
    void add(const YAML::Node& at, bool fatal, const std::string& message);
    std::vector<Problem>& problems_;
};

}  // namespace roomfix
