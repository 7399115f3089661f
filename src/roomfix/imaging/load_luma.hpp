// Luma from files and memory: JPEG straight to grey, everything else through OpenCV.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "roomfix/base/result.hpp"
#include "roomfix/imaging/colour_image.hpp"
#include "roomfix/imaging/luma.hpp"

namespace cv {
class Mat;
}

namespace roomfix {

/// A part of a picture: columns and rows of the scaled picture. Zero width or height means all of it.
struct JpegOptions {
    int scale = 1;  // 1, 2, 4 or 8: the picture is made that much smaller while decoding
    int crop_x = 0;
    int crop_y = 0;
    int crop_width = 0;
    int crop_height = 0;
};

/// Width and height that a JPEG's header states, without decoding it.
struct ImageSize {
    int width = 0;
    int height = 0;
};
Result<ImageSize> jpeg_size(std::span<const std::uint8_t> bytes);

/// Decodes only the luma of a JPEG into `image` (resized; no allocation when the size stays). The crop is exact, except
/// that it must lie inside the scaled picture. Damaged or truncated data is an error, never half a picture.
Result<void> decode_jpeg_luma(std::span<const std::uint8_t> bytes, LumaImage& image, const JpegOptions& options = {});

/// Any OpenCV image (1, 3 or 4 channels, 8 or 16 bit) as luma: 0.299 R + 0.587 G + 0.114 B, Li (12). Sixteen-bit images
/// are scaled by 1/256. Other formats are an error.
Result<void> luma_from_mat(const cv::Mat& mat, LumaImage& image);

/// A picture in memory in any format that OpenCV reads; JPEG takes the fast path.
Result<void> decode_luma(std::span<const std::uint8_t> bytes, LumaImage& image);

/// The same from a file; the error names the file. `buffer` keeps its memory between calls.
Result<void> load_luma(const std::filesystem::path& file, LumaImage& image, std::vector<std::uint8_t>& buffer);
Result<LumaImage> load_luma(const std::filesystem::path& file);

/// A picture as luma and, small, in colour. Same formats and errors as above.
Result<void> decode_picture(std::span<const std::uint8_t> bytes, LumaImage& image, ColourImage& colour);
Result<void> load_picture(const std::filesystem::path& file, LumaImage& image, ColourImage& colour, std::vector<std::uint8_t>& buffer);
/// The colours of any OpenCV image that luma_from_mat() takes.
Result<void> colour_from_mat(const cv::Mat& mat, ColourImage& colour);

/// The small colour picture of a JPEG. Errors as of decode_jpeg_luma().
Result<void> decode_jpeg_colour(std::span<const std::uint8_t> bytes, ColourImage& colour);

/// A grey image as JPEG (quality 1..100).
std::vector<std::uint8_t> encode_jpeg(LumaView image, int quality);

/// Writes a grey image as PNG or JPEG, by the file's ending.
Result<void> save_luma(const std::filesystem::path& file, LumaView image);

}  // namespace roomfix
