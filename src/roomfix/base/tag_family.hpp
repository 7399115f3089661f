// The dictionaries of printed square tags that can be read: AprilTag's families and ArUco's.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace roomfix {

enum class TagFamily {
    tag36h11,
    tag36h10,
    tag25h9,
    tag16h5,
    tag_circle21h7,
    tag_circle49h12,
    tag_custom48h12,
    tag_standard41h12,
    tag_standard52h13,
    aruco_4x4_50,
    aruco_4x4_100,
    aruco_4x4_250,
    aruco_4x4_1000,
    aruco_5x5_50,
    aruco_5x5_100,
    aruco_5x5_250,
    aruco_5x5_1000,
    aruco_6x6_50,
    aruco_6x6_100,
    aruco_6x6_250,
    aruco_6x6_1000,
    aruco_7x7_50,
    aruco_7x7_100,
    aruco_7x7_250,
    aruco_7x7_1000,
    aruco_original
};

/// As libapriltag and OpenCV write it: tagStandard41h12, DICT_4X4_50.
const char* name_of(TagFamily family);
/// Nothing for a name that no dictionary has.
std::optional<TagFamily> tag_family_named(std::string_view name);
/// How many tags it has: their numbers start at 0.
int tag_count(TagFamily family);
bool is_aruco(TagFamily family);
/// All names, for messages.
std::vector<std::string> tag_family_names();

}  // namespace roomfix
