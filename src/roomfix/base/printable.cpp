#include "roomfix/base/printable.hpp"

#include <cstdint>

namespace roomfix {
namespace {

bool continues(std::string_view text, std::size_t at) { return at < text.size() && (static_cast<unsigned char>(text[at]) & 0xC0) == 0x80; }

struct Character {
    std::size_t length = 0;  // bytes; 0: the text does not begin with UTF-8
    std::uint32_t code = 0;

    bool is_control() const { return code < ' ' || (code >= 0x7F && code < 0xA0); }
};

Character first_character(std::string_view text) {
    const auto first = static_cast<unsigned char>(text[0]);
    if (first < 0x80) return {1, first};
    const std::size_t length = first >= 0xF0 ? 4 : first >= 0xE0 ? 3 : 2;
    if (first < 0xC2 || first > 0xF4) return {};
    std::uint32_t code = first & (0xFFU >> (length + 1));
    for (std::size_t i = 1; i < length; ++i) {
        if (!continues(text, i)) return {};
        code = code << 6U | (static_cast<unsigned char>(text[i]) & 0x3FU);
    }
    const bool too_long = (length == 3 && code < 0x800) || (length == 4 && code < 0x10000);
    const bool no_character = (code >= 0xD800 && code < 0xE000) || code > 0x10FFFF;
    return too_long || no_character ? Character{} : Character{length, code};
}

}  // namespace

std::string printable(std::string_view text) {
    std::string shown;
    while (!text.empty()) {
        const Character character = first_character(text);
        const bool can_be_shown = character.length > 0 && !character.is_control();
        shown += can_be_shown ? text.substr(0, character.length) : "?";
        text.remove_prefix(can_be_shown ? character.length : 1);
    }
    return shown;
}

std::optional<std::size_t> first_that_is_not_utf8(std::string_view text) {
    for (std::size_t at = 0; at < text.size();) {
        const std::size_t length = first_character(text.substr(at)).length;
        if (length == 0) return at;
        at += length;
    }
    return std::nullopt;
}

}  // namespace roomfix
