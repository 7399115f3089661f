#include "roomfix/base/tag_family.hpp"

#include <array>

namespace roomfix {
namespace {

struct Described {
    const char* name;
    int count;
};

// In the order of TagFamily.
constexpr std::array<Described, 26> described = {{
    {"tag36h11", 587},
    {"tag36h10", 2320},
    {"tag25h9", 35},
    {"tag16h5", 30},
    {"tagCircle21h7", 38},
    {"tagCircle49h12", 65535},
    {"tagCustom48h12", 42211},
    {"tagStandard41h12", 2115},
    {"tagStandard52h13", 48714},
    {"DICT_4X4_50", 50},
    {"DICT_4X4_100", 100},
    {"DICT_4X4_250", 250},
    {"DICT_4X4_1000", 1000},
    {"DICT_5X5_50", 50},
    {"DICT_5X5_100", 100},
    {"DICT_5X5_250", 250},
    {"DICT_5X5_1000", 1000},
    {"DICT_6X6_50", 50},
    {"DICT_6X6_100", 100},
    {"DICT_6X6_250", 250},
    {"DICT_6X6_1000", 1000},
    {"DICT_7X7_50", 50},
    {"DICT_7X7_100", 100},
    {"DICT_7X7_250", 250},
    {"DICT_7X7_1000", 1000},
    {"DICT_ARUCO_ORIGINAL", 1024},
}};

const Described& of(TagFamily family) { return described[static_cast<std::size_t>(family)]; }

}  // namespace

const char* name_of(TagFamily family) { return of(family).name; }
int tag_count(TagFamily family) { return of(family).count; }
bool is_aruco(TagFamily family) { return family >= TagFamily::aruco_4x4_50; }

std::optional<TagFamily> tag_family_named(std::string_view name) {
    for (std::size_t i = 0; i < described.size(); ++i) {
        if (name == described[i].name) return static_cast<TagFamily>(i);
    }
    return std::nullopt;
}

std::vector<std::string> tag_family_names() {
    std::vector<std::string> names;
    for (const Described& family : described) names.emplace_back(family.name);
    return names;
}

}  // namespace roomfix
