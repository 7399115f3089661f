#include "roomfix/imaging/y4m.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>
#include <string_view>

namespace roomfix {
namespace {

constexpr std::string_view magic = "YUV4MPEG2 ";
constexpr std::string_view frame_magic = "FRAME";
constexpr int largest_y4m_side = 32768;

/// How a file names the places of the colours.
struct Kind {
    std::string_view name;
    int shift_x, shift_y;
};
constexpr std::array<Kind, 10> kinds = {{{"420jpeg", 1, 1},
                                         {"420mpeg2", 1, 1},
                                         {"420paldv", 1, 1},
                                         {"420", 1, 1},
                                         {"422", 1, 0},
                                         {"444", 0, 0},
                                         {"411", 2, 0},
                                         {"410", 2, 2},
                                         {"440", 0, 1},
                                         {"mono", -1, -1}}};  // no colours

std::string_view text_of(std::span<const std::uint8_t> bytes) { return {reinterpret_cast<const char*>(bytes.data()), bytes.size()}; }

int side_of(std::string_view text) {
    int value = 0;
    const auto read = std::from_chars(text.data(), text.data() + text.size(), value);
    return read.ec == std::errc() && read.ptr == text.data() + text.size() ? value : 0;
}

/// A plane's size where the whole picture has that one.
int shrunk(int side, int shift) { return (side + (1 << shift) - 1) >> shift; }

/// What the first line says; nothing where it cannot be used.
struct Header {
    int width = 0, height = 0;
    Kind kind = kinds[0];
    bool full_range = false;
};
std::optional<Header> header_of(std::string_view line) {
    Header header;
    while (!line.empty()) {
        const std::size_t end = std::min(line.find(' '), line.size());
        const std::string_view word = line.substr(0, end);
        line.remove_prefix(std::min(end + 1, line.size()));
        if (word.starts_with('W')) header.width = side_of(word.substr(1));
        if (word.starts_with('H')) header.height = side_of(word.substr(1));
        if (word == "XCOLORRANGE=FULL") header.full_range = true;
        if (!word.starts_with('C')) continue;
        const auto* const kind = std::find_if(kinds.begin(), kinds.end(), [&](const Kind& k) { return k.name == word.substr(1); });
        if (kind == kinds.end()) return std::nullopt;
        header.kind = *kind;
    }
    const auto possible = [](int side) { return side > 0 && side <= largest_y4m_side; };
    return possible(header.width) && possible(header.height) ? std::optional(header) : std::nullopt;
}

void add_plane(const std::uint8_t* plane, std::ptrdiff_t stride, int step, int width, int height, std::vector<std::uint8_t>& bytes) {
    for (int y = 0; y < height; ++y) {
        const std::uint8_t* row = plane + y * stride;
        if (step == 1) {
            bytes.insert(bytes.end(), row, row + width);
        } else {
            for (int x = 0; x < width; ++x) bytes.push_back(row[x * step]);
        }
    }
}

}  // namespace

bool is_y4m(std::span<const std::uint8_t> bytes) { return text_of(bytes).starts_with(magic); }

Result<YuvView> y4m_view(std::span<const std::uint8_t> bytes) {
    const Error damaged{"the .y4m picture is damaged or cut off: record or copy it again"};
    const std::string_view text = text_of(bytes);
    const std::size_t line_end = text.substr(0, 1024).find('\n');
    if (!is_y4m(bytes) || line_end == text.npos) return damaged;
    const auto header = header_of(text.substr(magic.size(), line_end - magic.size()));
    if (!header) return Error{"the .y4m picture is of a kind that is not read: make it 8 bits, 4:2:0, 4:2:2 or 4:4:4"};
    const std::size_t frame = line_end + 1;
    const std::size_t frame_end = text.substr(0, frame + 1024).find('\n', frame);
    if (!text.substr(frame).starts_with(frame_magic) || frame_end == text.npos) return damaged;
    YuvView view;
    view.width = header->width;
    view.height = header->height;
    view.full_range = header->full_range;
    view.y = bytes.data() + frame_end + 1;
    view.y_stride = view.width;
    std::size_t size = static_cast<std::size_t>(view.width) * static_cast<std::size_t>(view.height);
    if (header->kind.shift_x >= 0) {
        view.shift_x = header->kind.shift_x;
        view.shift_y = header->kind.shift_y;
        view.colour_stride = shrunk(view.width, view.shift_x);
        const std::size_t plane = static_cast<std::size_t>(view.colour_stride) * static_cast<std::size_t>(shrunk(view.height, view.shift_y));
        view.u = view.y + size;
        view.v = view.u + plane;
        size += 2 * plane;
    }
    if (bytes.size() - (frame_end + 1) < size) return damaged;
    return view;
}

Result<std::vector<std::uint8_t>> encode_y4m(const YuvView& picture) {
    const bool grey = picture.u == nullptr;
    const auto* const kind = std::find_if(kinds.begin(), kinds.end(),
                                          [&](const Kind& k) { return grey ? k.shift_x < 0 : k.shift_x == picture.shift_x && k.shift_y == picture.shift_y; });
    if (kind == kinds.end()) return Error{"a picture has its colours at places that no .y4m file can state: set the camera to H.264, 4:2:0"};
    const std::string head = fmt::format("{}W{} H{} F25:1 Ip A1:1 C{} XCOLORRANGE={}\n{}\n", magic, picture.width, picture.height, kind->name,
                                         picture.full_range ? "FULL" : "LIMITED", frame_magic);
    std::vector<std::uint8_t> bytes;
    bytes.reserve(head.size() + 3 * static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.height));
    bytes.assign(head.begin(), head.end());
    add_plane(picture.y, picture.y_stride, picture.y_step, picture.width, picture.height, bytes);
    if (grey) return bytes;
    const int columns = shrunk(picture.width, picture.shift_x), rows = shrunk(picture.height, picture.shift_y);
    add_plane(picture.u, picture.colour_stride, picture.colour_step, columns, rows, bytes);
    add_plane(picture.v, picture.colour_stride, picture.colour_step, columns, rows, bytes);
    return bytes;
}

}  // namespace roomfix
