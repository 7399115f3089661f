// One picture as a YUV4MPEG2 file (.y4m), which players open: brightness and colour as a camera or a decoder gave them, nothing lost.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "roomfix/base/result.hpp"
#include "roomfix/imaging/yuv_picture.hpp"

namespace roomfix {

bool is_y4m(std::span<const std::uint8_t> bytes);

/// The first picture of a file, in its bytes. An error where it is damaged, or of a kind that is not read: 8 bits, colour at 1 to 4 times fewer columns and
/// rows.
Result<YuvView> y4m_view(std::span<const std::uint8_t> bytes);

/// The picture as a file. An error where there is no such kind.
Result<std::vector<std::uint8_t>> encode_y4m(const YuvView& picture);

/// The picture as a JPEG (quality 1..100), for whoever reads nothing else.
std::vector<std::uint8_t> encode_jpeg(const YuvView& picture, int quality);

}  // namespace roomfix
