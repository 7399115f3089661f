#include <fmt/format.h>
#include <jpeglib.h>

#include <algorithm>
#include <cmath>
#include <csetjmp>
#include <cstdlib>

#include "roomfix/imaging/load_luma.hpp"
#include "roomfix/imaging/y4m.hpp"

namespace roomfix {
namespace {

constexpr int largest_side = 32768;

struct ErrorManager {
    jpeg_error_mgr base;  // first member: libjpeg sees only this
    std::jmp_buf leave;
    char text[JMSG_LENGTH_MAX] = "";
};

void fail(j_common_ptr codec) {
    auto* manager = reinterpret_cast<ErrorManager*>(codec->err);
    codec->err->format_message(codec, manager->text);
    std::longjmp(manager->leave, 1);
}

/// libjpeg calls this for damage that it would paper over (level -1): that is an error here.
void note_damage(j_common_ptr codec, int level) {
    if (level < 0) fail(codec);
}

void install(jpeg_decompress_struct& codec, ErrorManager& manager) {
    codec.err = jpeg_std_error(&manager.base);
    manager.base.error_exit = fail;
    manager.base.emit_message = note_damage;
}

Error damaged(const ErrorManager& manager) { return {fmt::format("damaged or truncated JPEG ({}): record or copy the picture again", manager.text)}; }

/// Reads the header and sets up a grey, scaled decoder. False if the requested crop does not fit.
bool start(jpeg_decompress_struct& codec, std::span<const std::uint8_t> bytes, const JpegOptions& options) {
    jpeg_mem_src(&codec, bytes.data(), bytes.size());
    jpeg_read_header(&codec, TRUE);
    codec.out_color_space = JCS_GRAYSCALE;
    codec.scale_num = 1;
    codec.scale_denom = static_cast<unsigned>(options.scale);
    jpeg_calc_output_dimensions(&codec);
    const int width = static_cast<int>(codec.output_width);
    const int height = static_cast<int>(codec.output_height);
    return options.crop_x >= 0 && options.crop_y >= 0 && options.crop_width >= 0 && options.crop_height >= 0 && options.crop_x < width &&
           options.crop_y < height && options.crop_width <= width - options.crop_x && options.crop_height <= height - options.crop_y;
}

/// Decodes the rows of the crop into `image`. libjpeg crops to whole blocks, so each row passes through `line`.
void read_rows(jpeg_decompress_struct& codec, LumaImage& image, const JpegOptions& options, std::uint8_t* line) {
    jpeg_start_decompress(&codec);
    const bool whole_width = image.width() == static_cast<int>(codec.output_width);
    JDIMENSION left = static_cast<JDIMENSION>(options.crop_x);
    JDIMENSION width = static_cast<JDIMENSION>(image.width());
    if (!whole_width) jpeg_crop_scanline(&codec, &left, &width);
    const auto first = static_cast<std::size_t>(options.crop_x) - left;
    if (options.crop_y > 0) jpeg_skip_scanlines(&codec, static_cast<JDIMENSION>(options.crop_y));
    for (int y = 0; y < image.height(); ++y) {
        JSAMPROW target = whole_width ? image.row(y) : line;
        jpeg_read_scanlines(&codec, &target, 1);
        if (!whole_width) std::memcpy(image.row(y), line + first, static_cast<std::size_t>(image.width()));
    }
    if (codec.output_scanline < codec.output_height) {
        jpeg_abort_decompress(&codec);
    } else {
        jpeg_finish_decompress(&codec);
    }
}

}  // namespace

Result<ImageSize> jpeg_size(std::span<const std::uint8_t> bytes) {
    jpeg_decompress_struct codec;
    ErrorManager manager;
    install(codec, manager);
    if (setjmp(manager.leave)) {
        jpeg_destroy_decompress(&codec);
        return damaged(manager);
    }
    jpeg_create_decompress(&codec);
    jpeg_mem_src(&codec, bytes.data(), bytes.size());
    jpeg_read_header(&codec, TRUE);
    const ImageSize size{static_cast<int>(codec.image_width), static_cast<int>(codec.image_height)};
    jpeg_destroy_decompress(&codec);
    return size;
}

Result<void> decode_jpeg_luma(std::span<const std::uint8_t> bytes, LumaImage& image, const JpegOptions& options) {
    if (bytes.empty()) return Error{"empty JPEG: the file has no bytes"};
    if (options.scale != 1 && options.scale != 2 && options.scale != 4 && options.scale != 8) {
        return Error{fmt::format("JPEG scale {} is not possible: use 1, 2, 4 or 8", options.scale)};
    }
    const auto stated = jpeg_size(bytes);
    if (!stated) return stated.error();
    if (stated->width > largest_side || stated->height > largest_side) {
        return Error{fmt::format("JPEG of {} x {} pixels is too large (limit {})", stated->width, stated->height, largest_side)};
    }

    thread_local std::vector<std::uint8_t> line;  // before setjmp: a longjmp must not skip its construction
    jpeg_decompress_struct codec;
    ErrorManager manager;
    install(codec, manager);
    if (setjmp(manager.leave)) {
        jpeg_destroy_decompress(&codec);
        return damaged(manager);
    }
    jpeg_create_decompress(&codec);
    if (!start(codec, bytes, options)) {
        jpeg_destroy_decompress(&codec);
        return Error{fmt::format("the requested part ({}, {}) {} x {} is outside the {} x {} picture", options.crop_x, options.crop_y, options.crop_width,
                                 options.crop_height, codec.output_width, codec.output_height)};
    }
    const int full_width = static_cast<int>(codec.output_width);
    const int full_height = static_cast<int>(codec.output_height);
    if (line.size() < static_cast<std::size_t>(full_width) + 64) line.resize(static_cast<std::size_t>(full_width) + 64);
    image.resize(options.crop_width > 0 ? options.crop_width : full_width - options.crop_x,
                 options.crop_height > 0 ? options.crop_height : full_height - options.crop_y);
    read_rows(codec, image, options, line.data());
    jpeg_destroy_decompress(&codec);
    return {};
}

Result<void> decode_jpeg_colour(std::span<const std::uint8_t> bytes, ColourImage& colour) {
    thread_local std::vector<std::uint8_t> pixels;  // before setjmp: a longjmp must not skip its construction
    jpeg_decompress_struct codec;
    ErrorManager manager;
    install(codec, manager);
    if (setjmp(manager.leave)) {
        jpeg_destroy_decompress(&codec);
        return damaged(manager);
    }
    jpeg_create_decompress(&codec);
    jpeg_mem_src(&codec, bytes.data(), bytes.size());
    jpeg_read_header(&codec, TRUE);
    const bool grey = codec.num_components == 1;
    if (codec.image_width > static_cast<unsigned>(largest_side) || codec.image_height > static_cast<unsigned>(largest_side)) {
        jpeg_destroy_decompress(&codec);
        return Error{"the JPEG is too large"};
    }
    codec.out_color_space = grey ? JCS_GRAYSCALE : JCS_EXT_BGR;
    jpeg_start_decompress(&codec);
    const int width = static_cast<int>(codec.output_width);
    const int height = static_cast<int>(codec.output_height);
    const std::ptrdiff_t stride = std::ptrdiff_t{width} * (grey ? 1 : 3);
    pixels.resize(static_cast<std::size_t>(stride * height));
    for (int y = 0; y < height; ++y) {
        JSAMPROW row = pixels.data() + y * stride;
        jpeg_read_scanlines(&codec, &row, 1);
    }
    jpeg_finish_decompress(&codec);
    jpeg_destroy_decompress(&codec);
    if (grey) {
        shrink_grey({pixels.data(), width, height, stride}, colour);
    } else {
        shrink_colour(pixels.data(), width, height, stride, colour);
    }
    return {};
}

/// Encodes rows of `components` values side by side, which `row(y)` gives; they are grey, or brightness and colours as JPEG has them.
template <class Row>
static std::vector<std::uint8_t> encode_rows(int width, int height, int components, int quality, const Row& row) {
    jpeg_compress_struct codec;
    jpeg_error_mgr manager;
    codec.err = jpeg_std_error(&manager);  // memory output of a valid image has no error to report
    jpeg_create_compress(&codec);
    unsigned char* memory = nullptr;
    unsigned long size = 0;
    jpeg_mem_dest(&codec, &memory, &size);
    codec.image_width = static_cast<JDIMENSION>(width);
    codec.image_height = static_cast<JDIMENSION>(height);
    codec.input_components = components;
    codec.in_color_space = components == 1 ? JCS_GRAYSCALE : JCS_YCbCr;
    jpeg_set_defaults(&codec);
    jpeg_set_quality(&codec, quality, TRUE);
    jpeg_start_compress(&codec, TRUE);
    for (int y = 0; y < height; ++y) {
        JSAMPROW values = const_cast<JSAMPROW>(row(y));
        jpeg_write_scanlines(&codec, &values, 1);
    }
    jpeg_finish_compress(&codec);
    jpeg_destroy_compress(&codec);
    std::vector<std::uint8_t> bytes(memory, memory + size);
    std::free(memory);
    return bytes;
}

std::vector<std::uint8_t> encode_jpeg(LumaView image, int quality) {
    return encode_rows(image.width, image.height, 1, quality, [&](int y) { return image.row(y); });
}

std::vector<std::uint8_t> encode_jpeg(const YuvView& picture, int quality) {
    LumaImage luma;
    luma_from_yuv(picture, luma);
    if (picture.u == nullptr) return encode_jpeg(luma.view(), quality);
    const double gain = picture.full_range ? 1 : 255.0 / 224;  // of video's colours
    const auto full = [gain](int value) { return static_cast<std::uint8_t>(std::clamp(std::lround(128 + gain * (value - 128)), 0L, 255L)); };
    std::vector<std::uint8_t> line(3 * static_cast<std::size_t>(picture.width));
    return encode_rows(picture.width, picture.height, 3, quality, [&](int y) {
        const std::ptrdiff_t row = (y >> picture.shift_y) * picture.colour_stride;
        std::uint8_t* to = line.data();
        for (int x = 0; x < picture.width; ++x) {
            const std::ptrdiff_t place = row + std::ptrdiff_t{x >> picture.shift_x} * picture.colour_step;
            *to++ = luma.row(y)[x];
            *to++ = full(picture.u[place]);
            *to++ = full(picture.v[place]);
        }
        return static_cast<const std::uint8_t*>(line.data());
    });
}

}  // namespace roomfix
