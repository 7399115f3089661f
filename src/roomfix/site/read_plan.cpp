#include "roomfix/site/read_plan.hpp"

#include <fmt/format.h>

#include <array>
#include <cctype>
#include <fstream>
#include <iterator>

#include "roomfix/base/number.hpp"
#include "roomfix/base/text_file.hpp"
#include "roomfix/geometry/pose.hpp"
#include "roomfix/site/quoted_text.hpp"

namespace roomfix {
namespace {

constexpr double finest = 1e-4, coarsest = 10;  // m per pixel
constexpr double most_degrees = 360;

struct PictureSize {
    long width = 0, height = 0;  // px
};

/// Of a PNG: the first chunk begins with it.
std::optional<PictureSize> png_size(std::string_view head) {
    constexpr std::string_view signature("\x89PNG\r\n\x1a\n", 8);
    if (head.size() < 24 || !head.starts_with(signature) || head.substr(12, 4) != "IHDR") return std::nullopt;
    const auto number = [&](std::size_t at) {
        long value = 0;
        for (std::size_t i = at; i < at + 4; ++i) value = value << 8 | static_cast<unsigned char>(head[i]);
        return value;
    };
    return PictureSize{number(16), number(20)};
}

/// Of a PGM or PPM: two numbers behind the kind, with comments between them.
std::optional<PictureSize> netpbm_size(std::string_view head) {
    if (head.size() < 3 || head[0] != 'P' || std::string_view("2356").find(head[1]) == std::string_view::npos) return std::nullopt;
    std::array<long, 2> numbers = {0, 0};
    std::size_t at = 2;
    for (long& number : numbers) {
        while (at < head.size() && (std::isspace(static_cast<unsigned char>(head[at])) != 0 || head[at] == '#')) {
            at = head[at] == '#' ? std::min(head.find('\n', at), head.size()) : at + 1;
        }
        const std::size_t begin = at;
        for (; at < head.size() && head[at] >= '0' && head[at] <= '9' && at < begin + 9; ++at) number = 10 * number + (head[at] - '0');
        if (at == begin) return std::nullopt;
    }
    return PictureSize{numbers[0], numbers[1]};
}

/// A value of a map file, which is not ours: what is wrong with it is one sentence.
std::optional<double> number_of(const YAML::Node& node) { return node.IsDefined() && node.IsScalar() ? parse_number(node.Scalar()) : std::nullopt; }

Result<MapFile> map_file_of(const YAML::Node& root) {
    MapFile map;
    if (!root.IsMap()) return Error{"it is no map file: it needs 'image', 'resolution' and 'origin'"};
    const auto at = [](const YAML::Node& node) { return node.IsDefined() && node.Mark().line >= 0 ? fmt::format("line {}: ", node.Mark().line + 1) : ""; };
    const YAML::Node image = root["image"];
    if (!image.IsDefined() || !image.IsScalar() || image.Scalar().empty()) return Error{at(image) + "'image' must name the picture"};
    map.image = image.Scalar();
    const auto resolution = number_of(root["resolution"]);
    if (!resolution || *resolution < finest || *resolution > coarsest) {
        return Error{fmt::format("{}'resolution' must be metres per pixel, {} to {}", at(root["resolution"]), finest, coarsest)};
    }
    map.resolution = *resolution;
    const YAML::Node origin = root["origin"];
    std::array<std::optional<double>, 3> numbers;
    for (std::size_t i = 0; i < 3 && origin.IsDefined() && origin.IsSequence() && origin.size() == 3; ++i) numbers[i] = number_of(origin[i]);
    const auto possible = [](const std::optional<double>& number, double most) { return number && std::abs(*number) <= most; };
    if (!possible(numbers[0], 1e5) || !possible(numbers[1], 1e5) || !possible(numbers[2], 100)) {
        return Error{at(origin) + "'origin' must be [x, y, yaw] of the picture's lower left corner, m and rad"};
    }
    map.map_from_plan = {*numbers[0], *numbers[1], wrap_angle(*numbers[2])};
    const YAML::Node negate = root["negate"];
    if (!negate.IsDefined()) return map;
    const std::string value = negate.IsScalar() ? negate.Scalar() : "";
    map.negate = value == "1" || value == "true";
    if (!map.negate && value != "0" && value != "false") return Error{at(negate) + "'negate' must be 0 or 1"};
    return map;
}

std::optional<SitePlan> plan_of_map_file(YamlReader& reader, const YAML::Node& node, const std::filesystem::path& folder) {
    const std::filesystem::path file = folder / node.Scalar();
    const auto map = load_map_file(file);
    const auto picture = map ? check_plan_picture(file.parent_path() / map->image) : Result<void>(map.error());
    if (picture) return SitePlan{node.Scalar(), map->resolution, map->map_from_plan};
    reader.error(node, "plan: " + picture.error().message);
    return std::nullopt;
}

}  // namespace

Result<MapFile> parse_map_file(std::string_view text) {
    try {
        return map_file_of(YAML::Load(std::string(text)));
    } catch (const YAML::Exception& problem) {
        return Error{fmt::format("line {}: not valid YAML: {}", problem.mark.line + 1, problem.msg)};
    }
}

Result<MapFile> load_map_file(const std::filesystem::path& file) {
    const auto text = read_text(file);
    if (!text) return text.error();
    auto map = parse_map_file(*text);
    if (!map) return Error{fmt::format("{}: {}", file.string(), map.error().message)};
    return map;
}

bool is_map_file(const std::string& file) { return file.ends_with(".yaml") || file.ends_with(".yml"); }

Result<void> check_plan_picture(const std::filesystem::path& file) {
    std::error_code failure;
    std::ifstream stream(file, std::ios::binary);
    if (!stream || std::filesystem::is_directory(file, failure)) return Error{file.string() + ": cannot be read: check the name of the plan's picture"};
    std::string head(4096, '\0');
    stream.read(head.data(), static_cast<std::streamsize>(head.size()));
    head.resize(static_cast<std::size_t>(stream.gcount()));
    auto size = png_size(head);
    if (!size) size = netpbm_size(head);
    if (!size) return Error{file.string() + ": is no PNG, PGM or PPM picture: convert it to PNG"};
    if (size->width < 1 || size->height < 1 || size->width > largest_plan || size->height > largest_plan) {
        return Error{fmt::format("{}: is {} x {} pixels: a plan may have up to {} on each side", file.string(), size->width, size->height, largest_plan)};
    }
    return {};
}

std::optional<SitePlan> read_plan(YamlReader& reader, const YAML::Node& node, const std::filesystem::path& folder) {
    if (!node.IsDefined()) return std::nullopt;
    if (node.IsScalar() && is_map_file(node.Scalar())) return plan_of_map_file(reader, node, folder);
    if (node.IsScalar()) {
        reader.error(node, "plan is the file of a map server, map.yaml, or {image: plan.png, resolution: metres per pixel, origin: [x, y, degrees]}");
        return std::nullopt;
    }
    if (!reader.map(node, "plan", {"image", "resolution", "origin"})) return std::nullopt;
    const auto image = reader.text(reader.required(node, "image", "plan"), "plan.image");
    const auto resolution = reader.number(reader.required(node, "resolution", "plan"), "plan.resolution", finest, coarsest);
    const YAML::Node origin = node["origin"];
    SitePlan plan;
    if (origin.IsDefined()) {
        const auto numbers = reader.numbers(origin, "plan.origin", 3, -1e5, 1e5);
        if (!numbers) return std::nullopt;
        if (std::abs((*numbers)[2]) > most_degrees) reader.error(origin, "plan.origin: the third number turns the picture, in degrees from -360 to 360");
        plan.map_from_plan = {(*numbers)[0], (*numbers)[1], wrap_angle(radians((*numbers)[2]))};
    }
    if (!image || !resolution) return std::nullopt;
    plan.image = *image;
    plan.resolution = *resolution;
    if (const auto picture = check_plan_picture(folder / *image); !picture) reader.error(node["image"], "plan.image: " + picture.error().message);
    return plan;
}

std::string plan_text(const SitePlan& plan) {
    if (is_map_file(plan.image)) return quoted_text(plan.image);
    const Pose2& origin = plan.map_from_plan;
    return fmt::format("{{image: {}, resolution: {}, origin: [{}, {}, {}]}}", quoted_text(plan.image), number_text(plan.resolution), number_text(origin.x),
                       number_text(origin.y), number_text(degrees(origin.yaw)));
}

}  // namespace roomfix
