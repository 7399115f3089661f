// Any bytes as a picture, whole, scaled and cropped: a picture or an error, never a crash.
#include "roomfix/imaging/load_luma.hpp"

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
    // Pictures that state a huge size are refused by their decoders; keep the fuzzer fast.
    const auto stated = roomfix::jpeg_size({data, size});
    if (stated && static_cast<long>(stated->width) * stated->height > 1'000'000) return 0;
    roomfix::LumaImage image;
    roomfix::ColourImage colour;
    (void)roomfix::decode_picture({data, size}, image, colour);
    (void)roomfix::decode_jpeg_colour({data, size}, colour);
    if (!roomfix::decode_luma({data, size}, image)) return 0;
    (void)roomfix::decode_jpeg_luma({data, size}, image, {.scale = 2});
    (void)roomfix::decode_jpeg_luma({data, size}, image, {.scale = 1, .crop_x = image.width() / 3, .crop_y = 1, .crop_width = 5, .crop_height = 3});
    return 0;
}
