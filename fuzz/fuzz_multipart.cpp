// Streams of pictures from HTTP cameras: whatever comes, in whatever pieces, is parts or an error.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "roomfix/connect/multipart_reader.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    if (size < 1) return 0;
    const std::size_t piece = 1 + data[0];
    roomfix::MultipartReader whole, pieces;
    std::size_t from_whole = 0, from_pieces = 0;
    const bool good = static_cast<bool>(whole.feed({data + 1, size - 1}, 0));
    while (const auto part = whole.take()) {
        if (part->body.empty() || part->body.size() > size) std::abort();
        from_whole += part->body.size();
    }
    bool still_good = true;
    for (std::size_t i = 1; i < size && still_good; i += piece) {
        still_good = static_cast<bool>(pieces.feed({data + i, std::min(piece, size - i)}, static_cast<double>(i)));
        while (const auto part = pieces.take()) from_pieces += part->body.size();
    }
    // How a stream is cut up on its way does not matter.
    if (good && still_good && from_whole != from_pieces) std::abort();
    return 0;
}
