#include "roomfix/site/learned_body.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "roomfix/base/number.hpp"
#include "roomfix/base/text_file.hpp"
#include "roomfix/geometry/pose.hpp"
#include "roomfix/site/body_parts.hpp"
#include "roomfix/site/yaml_reader.hpp"

namespace roomfix {
namespace {

constexpr std::size_t most_spots = 20000;
constexpr double largest = 50;  // m

void read_parts(YamlReader& reader, const YAML::Node& node, LearnedBody& body) {
    if (!reader.list(node, "parts")) return;
    if (node.size() == 0 || node.size() > most_parts)
        return reader.error(node, fmt::format("parts: {} of them, 1 to {} are possible", node.size(), most_parts));
    for (const auto& item : node) {
        if (!reader.list(item, "a part")) return;
        if (item.size() < 4 || item.size() > most_points_of_part)
            return reader.error(item, fmt::format("a part has {} points, 4 to {} are possible", item.size(), most_points_of_part));
        ConvexPart part;
        for (const auto& point : item) {
            const auto p = reader.numbers(point, "a part's point", 3, -largest, largest);
            if (!p) return;
            part.points.emplace_back((*p)[0], (*p)[1], (*p)[2]);
        }
        body.parts.push_back(std::move(part));
    }
}

/// Each spot is a row of place, direction, colour and sigma.
void read_spots(YamlReader& reader, const YAML::Node& node, BodyLook& look) {
    if (!reader.list(node, "spots")) return;
    if (node.size() > most_spots) return reader.error(node, fmt::format("{} spots are too many, {} are possible", node.size(), most_spots));
    const auto channels = static_cast<std::size_t>(look.channels);
    for (const auto& row : node) {
        const auto v = reader.numbers(row, "a spot (place, direction, colour, sigma)", 7 + channels, -largest, largest);
        if (!v) return;
        LookSpot spot;
        const auto at = [&](std::size_t i) { return static_cast<float>((*v)[i]); };
        spot.place = {at(0), at(1), at(2)};
        spot.outwards = {at(3), at(4), at(5)};
        for (std::size_t k = 0; k < channels; ++k) spot.colour[k] = at(6 + k);
        spot.sigma = at(6 + channels);
        if (std::abs(spot.outwards.norm() - 1) > 0.05f || spot.sigma < 0.01f)
            return reader.error(row, "a spot's direction must have length 1, its sigma be 0.01 or more");
        look.spots.push_back(spot);
    }
}

Agreement read_agreement(YamlReader& reader, const YAML::Node& root, const char* key) {
    const auto v = reader.numbers(reader.required(root, key, "a body file"), key, 2, -1000, 1000);
    if (!v) return {};
    if ((*v)[1] <= 0) reader.error(root[key], fmt::format("{}: the second number is a standard deviation, more than 0", key));
    return {(*v)[0], (*v)[1]};
}

LearnedBody read(YamlReader& reader, const YAML::Node& root) {
    LearnedBody body;
    if (!reader.map(root, "a body file",
                    {"roomfix_body", "learned_from", "size_sigma", "symmetry_deg", "channels", "as_robot", "as_clutter", "parts", "spots"}))
        return body;
    const auto version = reader.integer(reader.required(root, "roomfix_body", "a body file"), "roomfix_body", 0, 1000000);
    if (!version) return body;
    if (*version != learned_body_version) {
        reader.error(root["roomfix_body"], fmt::format("this body was learned by another version (format {}, this program reads {}): learn it again with "
                                                       "'roomfix calibrate robot'",
                                                       *version, learned_body_version));
        return body;
    }
    body.learned_from = reader.text(root["learned_from"], "learned_from").value_or("");
    body.size_sigma = reader.number(reader.required(root, "size_sigma", "a body file"), "size_sigma", 1e-5, 10).value_or(body.size_sigma);
    body.symmetry = radians(reader.number(reader.required(root, "symmetry_deg", "a body file"), "symmetry_deg", 0, 360).value_or(0));
    body.look.channels = reader.integer(reader.required(root, "channels", "a body file"), "channels", 1, 3).value_or(3);
    if (body.look.channels == 2) reader.error(root["channels"], "channels must be 1 (grey) or 3 (colour)");
    read_parts(reader, reader.required(root, "parts", "a body file"), body);
    constexpr double smallest = 0.01;  // m
    const Box box = box_around(body.parts);
    if (!body.parts.empty() && std::min({box.length, box.width, box.height}) < smallest) {
        reader.error(root["parts"], fmt::format("the parts are flat: a robot is at least {} m long, wide and high", smallest));
    }
    if (root["spots"].IsDefined()) {
        read_spots(reader, root["spots"], body.look);
        body.as_robot = read_agreement(reader, root, "as_robot");
        body.as_clutter = read_agreement(reader, root, "as_clutter");
    }
    return body;
}

}  // namespace

std::string learned_body_text(const LearnedBody& body) {
    const auto metres = [](double v) { return number_text(std::round(v * 1e4) / 1e4); };
    const auto rounded = [](double v) { return number_text(std::round(v * 1e3) / 1e3); };
    std::string text = fmt::format(
        "# a robot's body, learned by 'roomfix calibrate robot': in a site file, model: FILE.body\n"
        "roomfix_body: {}\nlearned_from: \"{}\"\nsize_sigma: {}\nsymmetry_deg: {}\nchannels: {}\n"
        "as_robot: [{}, {}]  # nats per spot: mean, sigma\nas_clutter: [{}, {}]\nparts:\n",
        learned_body_version, body.learned_from, metres(body.size_sigma), rounded(degrees(body.symmetry)), body.look.channels, rounded(body.as_robot.mean),
        rounded(body.as_robot.sigma), rounded(body.as_clutter.mean), rounded(body.as_clutter.sigma));
    for (const ConvexPart& part : body.parts) {
        text += "  - [";
        for (const auto& p : part.points)
            text += fmt::format("{}[{}, {}, {}]", &p == &part.points.front() ? "" : ", ", metres(p.x()), metres(p.y()), metres(p.z()));
        text += "]\n";
    }
    text += body.look.spots.empty() ? "" : "spots:  # place, direction outwards, log colours, sigma\n";
    for (const LookSpot& spot : body.look.spots) {
        text += "  - [";
        for (int i = 0; i < 3; ++i) text += metres(static_cast<double>(spot.place[i])) + ", ";
        for (int i = 0; i < 3; ++i) text += rounded(static_cast<double>(spot.outwards[i])) + ", ";
        for (std::size_t k = 0; k < static_cast<std::size_t>(body.look.channels); ++k) text += rounded(static_cast<double>(spot.colour[k])) + ", ";
        text += rounded(static_cast<double>(spot.sigma)) + "]\n";
    }
    return text;
}

Result<LearnedBody> parse_learned_body(const std::string& text, const std::string& name) {
    std::vector<Problem> problems;
    YamlReader reader(problems);
    LearnedBody body;
    try {
        body = read(reader, YAML::Load(text));
    } catch (const YAML::Exception& e) {
        return Error{fmt::format("{}:{}: {}", name, e.mark.line + 1, e.msg)};
    }
    for (const Problem& problem : problems) {
        if (problem.fatal) return Error{fmt::format("{}:{}: {}", name, problem.line, problem.message)};
    }
    return body;
}

Result<LearnedBody> read_learned_body(const std::filesystem::path& file) {
    const auto text = read_text(file);
    if (!text) return text.error();
    return parse_learned_body(*text, file.string());
}

}  // namespace roomfix
