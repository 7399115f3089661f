#include "roomfix/site/whole_mesh_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string_view>
#include <vector>

#include "roomfix/base/number.hpp"
#include "roomfix/base/text_lines.hpp"

namespace roomfix {
namespace {

std::uint32_t number_at(const std::string& bytes, std::size_t place) {
    std::uint32_t value = 0;
    std::memcpy(&value, bytes.data() + place, sizeof value);
    return value;
}

Result<void> check_stl(const std::string& bytes) {
    constexpr std::size_t head = 84;
    constexpr std::size_t triangle = 50;
    if (bytes.size() >= head && bytes.size() == head + std::size_t{number_at(bytes, 80)} * triangle) return {};
    if (bytes.starts_with("solid") && bytes.find("facet") != std::string::npos && bytes.find('\0') == std::string::npos) {
        if (bytes.find("endsolid", bytes.rfind("facet")) == std::string::npos) return Error{"the line 'endsolid' is missing at its end"};
        return {};
    }
    if (bytes.size() < head) return Error{"it is too short"};
    return Error{fmt::format("it states {} triangles, which do not make {} bytes", number_at(bytes, 80), bytes.size())};
}

/// Bytes of a number in a binary PLY; 0 for an unknown type.
std::size_t ply_size(std::string_view type) {
    if (type == "char" || type == "uchar" || type == "int8" || type == "uint8") return 1;
    if (type == "short" || type == "ushort" || type == "int16" || type == "uint16") return 2;
    if (type == "int" || type == "uint" || type == "float" || type == "int32" || type == "uint32" || type == "float32") return 4;
    return type == "double" || type == "float64" ? 8 : 0;
}

/// The words of a line.
std::vector<std::string_view> words_of(std::string_view line) {
    std::vector<std::string_view> words;
    while (true) {
        line.remove_prefix(std::min(line.find_first_not_of(" \t"), line.size()));
        if (line.empty()) return words;
        const std::size_t end = std::min(line.find_first_of(" \t"), line.size());
        words.push_back(line.substr(0, end));
        line.remove_prefix(end);
    }
}

/// The head of a PLY states how much follows. A list counts as three numbers, the corners of a triangle.
Result<void> check_ply(const std::string& bytes) {
    const std::size_t end = bytes.find("end_header");
    if (!bytes.starts_with("ply") || end == std::string::npos) return Error{"its head is not that of a PLY"};
    const std::size_t body = std::min(bytes.find('\n', end), bytes.size() - 1) + 1;
    bool text = true;
    double elements = 0, bytes_needed = 0, count = 0;
    std::string wrong;
    each_line(std::string_view(bytes).substr(0, end), [&](std::string_view line, long) {
        const auto words = words_of(line);
        if (words[0] == "format" && words.size() > 1) text = words[1] == "ascii";
        if (words[0] == "element") {
            const auto stated = words.size() == 3 ? parse_integer(words[2]) : std::nullopt;
            if (!stated || *stated < 0 || *stated > 1'000'000'000) wrong = fmt::format("'{}' is no count", line.substr(0, 60));
            count = stated ? static_cast<double>(*stated) : 0;
            elements += count;
        }
        if (words[0] == "property") {
            const bool list = words.size() == 5 && words[1] == "list";
            const std::size_t size = list ? ply_size(words[2]) + 3 * ply_size(words[3]) : words.size() == 3 ? ply_size(words[1]) : 0;
            if (size == 0) wrong = fmt::format("'{}' is no property", line.substr(0, 60));
            bytes_needed += count * static_cast<double>(size);
        }
    });
    if (!wrong.empty()) return Error{wrong};
    double there = static_cast<double>(bytes.size() - body);
    if (text) {
        there = 0;
        each_line(std::string_view(bytes).substr(body), [&](std::string_view, long) { ++there; });
    }
    if (there >= (text ? elements : bytes_needed)) return {};
    return Error{fmt::format("{:.0f} {} are missing at its end", (text ? elements : bytes_needed) - there, text ? "lines" : "bytes")};
}

Result<void> check_glb(const std::string& bytes) {
    if (bytes.size() < 20 || !bytes.starts_with("glTF")) return Error{"its head is not that of a GLB"};
    if (number_at(bytes, 8) > bytes.size()) return Error{fmt::format("it states {} bytes and has {}", number_at(bytes, 8), bytes.size())};
    return {};
}

}  // namespace

Result<void> check_whole(const std::string& bytes, const std::string& ending) {
    if (bytes.empty()) return Error{"it is empty"};
    if (ending == "stl") return check_stl(bytes);
    if (ending == "ply") return check_ply(bytes);
    if (ending == "glb") return check_glb(bytes);
    if (bytes.find('\0') != std::string::npos) return Error{"it is no text"};
    return {};
}

}  // namespace roomfix
