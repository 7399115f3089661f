#include "roomfix/imaging/load_luma.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string_view>

#include "roomfix/imaging/y4m.hpp"

namespace roomfix {
namespace {

/// True for the formats that are handed to OpenCV: PNG, BMP and PNM (P2 to P6). It knows many more, down to those of medicine and
/// geography, and some of their decoders end the program when the bytes are damaged.
bool known_format(std::span<const std::uint8_t> bytes) {
    const auto starts_with = [&](std::string_view text) {
        return bytes.size() >= text.size() &&
               std::equal(text.begin(), text.end(), bytes.begin(), [](char a, std::uint8_t b) { return static_cast<std::uint8_t>(a) == b; });
    };
    if (starts_with("\x89PNG\r\n\x1a\n") || starts_with("BM")) return true;
    const std::string_view space = " \t\n\r";
    return bytes.size() > 2 && bytes[0] == 'P' && bytes[1] >= '2' && bytes[1] <= '6' && space.find(static_cast<char>(bytes[2])) != space.npos;
}

}  // namespace

Result<void> luma_from_mat(const cv::Mat& mat, LumaImage& image) {
    if (mat.empty()) return Error{"the picture is empty"};
    if (mat.depth() != CV_8U && mat.depth() != CV_16U) {
        return Error{"pictures must have 8 or 16 bits per channel: convert it first"};
    }
    try {
        cv::Mat narrow = mat;
        if (mat.depth() == CV_16U) mat.convertTo(narrow, CV_8U, 1.0 / 256);
        image.resize(mat.cols, mat.rows);
        cv::Mat grey(mat.rows, mat.cols, CV_8UC1, image.row(0), static_cast<std::size_t>(image.view().stride));
        switch (mat.channels()) {
            case 1:
                narrow.copyTo(grey);
                break;
            case 3:
                cv::cvtColor(narrow, grey, cv::COLOR_BGR2GRAY);
                break;
            case 4:
                cv::cvtColor(narrow, grey, cv::COLOR_BGRA2GRAY);
                break;
            default:
                return Error{fmt::format("a picture with {} channels is not grey, BGR or BGRA", mat.channels())};
        }
    } catch (const cv::Exception& problem) {
        return Error{fmt::format("OpenCV could not convert the picture: {}", problem.err)};
    }
    return {};
}

Result<void> colour_from_mat(const cv::Mat& mat, ColourImage& colour) {
    try {
        cv::Mat narrow = mat;
        if (mat.depth() == CV_16U) mat.convertTo(narrow, CV_8U, 1.0 / 256);
        if (narrow.channels() == 4) cv::cvtColor(narrow, narrow, cv::COLOR_BGRA2BGR);
        const auto stride = static_cast<std::ptrdiff_t>(narrow.step);
        if (narrow.channels() == 3) {
            shrink_colour(narrow.data, narrow.cols, narrow.rows, stride, colour);
        } else {
            shrink_grey({narrow.data, narrow.cols, narrow.rows, stride}, colour);
        }
    } catch (const cv::Exception& problem) {
        return Error{fmt::format("OpenCV could not convert the picture: {}", problem.err)};
    }
    return {};
}

namespace {

bool is_jpeg(std::span<const std::uint8_t> bytes) { return bytes.size() > 2 && bytes[0] == 0xff && bytes[1] == 0xd8; }

/// Decodes a picture that is no JPEG, and gives it to `use`.
template <class Use>
Result<void> decode_other(std::span<const std::uint8_t> bytes, const Use& use) {
    if (bytes.empty()) return Error{"the picture has no bytes"};
    if (!known_format(bytes)) return Error{"not a picture, or one of a format that is not read: use JPEG or PNG (BMP, PGM, PPM and Y4M are read too)"};
    try {
        const cv::Mat raw(1, static_cast<int>(bytes.size()), CV_8UC1, const_cast<std::uint8_t*>(bytes.data()));
        const cv::Mat decoded = cv::imdecode(raw, cv::IMREAD_UNCHANGED | cv::IMREAD_IGNORE_ORIENTATION);
        if (decoded.empty()) return Error{"the picture is damaged: its first bytes are right, but it cannot be decoded"};
        return use(decoded);
    } catch (const std::exception& problem) {
        return Error{fmt::format("the picture could not be decoded ({}): use PNG or JPEG", problem.what())};
    }
}

/// Reads a file whole and gives its bytes to `decode`.
template <class Decode>
Result<void> load_file(const std::filesystem::path& file, std::vector<std::uint8_t>& buffer, const Decode& decode) {
    std::error_code failure;
    if (std::filesystem::is_directory(file, failure)) {
        return Error{fmt::format("{}: is a folder, not a picture: name the picture inside it", file.string())};
    }
    std::ifstream stream(file, std::ios::binary | std::ios::ate);
    if (!stream) return Error{fmt::format("{}: cannot be opened: check the name and the permissions", file.string())};
    buffer.resize(static_cast<std::size_t>(stream.tellg()));
    stream.seekg(0);
    stream.read(reinterpret_cast<char*>(buffer.data()), static_cast<std::streamsize>(buffer.size()));
    if (!stream) return Error{fmt::format("{}: cannot be read", file.string())};
    auto decoded = decode(std::span<const std::uint8_t>(buffer));
    if (!decoded) return Error{fmt::format("{}: {}", file.string(), decoded.error().message)};
    return {};
}

}  // namespace

Result<void> decode_luma(std::span<const std::uint8_t> bytes, LumaImage& image) {
    if (is_jpeg(bytes)) return decode_jpeg_luma(bytes, image);
    if (is_y4m(bytes)) {
        const auto view = y4m_view(bytes);
        if (!view) return view.error();
        luma_from_yuv(*view, image);
        return {};
    }
    return decode_other(bytes, [&](const cv::Mat& decoded) { return luma_from_mat(decoded, image); });
}

Result<void> decode_picture(std::span<const std::uint8_t> bytes, LumaImage& image, ColourImage& colour) {
    if (is_jpeg(bytes)) {
        if (auto luma = decode_jpeg_luma(bytes, image); !luma) return luma;
        return decode_jpeg_colour(bytes, colour);
    }
    if (is_y4m(bytes)) {
        const auto view = y4m_view(bytes);
        if (!view) return view.error();
        luma_from_yuv(*view, image);
        colour_from_yuv(*view, colour);
        return {};
    }
    return decode_other(bytes, [&](const cv::Mat& decoded) -> Result<void> {
        if (auto luma = luma_from_mat(decoded, image); !luma) return luma;
        return colour_from_mat(decoded, colour);
    });
}

Result<void> load_luma(const std::filesystem::path& file, LumaImage& image, std::vector<std::uint8_t>& buffer) {
    return load_file(file, buffer, [&](std::span<const std::uint8_t> bytes) { return decode_luma(bytes, image); });
}

Result<void> load_picture(const std::filesystem::path& file, LumaImage& image, ColourImage& colour, std::vector<std::uint8_t>& buffer) {
    return load_file(file, buffer, [&](std::span<const std::uint8_t> bytes) { return decode_picture(bytes, image, colour); });
}

Result<LumaImage> load_luma(const std::filesystem::path& file) {
    LumaImage image;
    std::vector<std::uint8_t> buffer;
    auto loaded = load_luma(file, image, buffer);
    if (!loaded) return loaded.error();
    return image;
}

Result<void> save_luma(const std::filesystem::path& file, LumaView image) {
    const cv::Mat grey(image.height, image.width, CV_8UC1, const_cast<std::uint8_t*>(image.data), static_cast<std::size_t>(image.stride));
    try {
        std::vector<int> options;
        if (file.extension() == ".jpg") options = {cv::IMWRITE_JPEG_QUALITY, 92};
        if (file.extension() == ".png") options = {cv::IMWRITE_PNG_COMPRESSION, 3};
        if (cv::imwrite(file.string(), grey, options)) return {};
    } catch (const cv::Exception&) {
    }
    return Error{fmt::format("{}: cannot be written: check that the folder exists and has room", file.string())};
}

}  // namespace roomfix
