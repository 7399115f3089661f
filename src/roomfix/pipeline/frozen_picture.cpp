#include "roomfix/pipeline/frozen_picture.hpp"

#include <cstring>

#include "roomfix/base/random.hpp"

namespace roomfix {

double FrozenPicture::seconds(LumaView frame, Nanoseconds time) {
    std::uint64_t sum = 0x9e3779b97f4a7c15ULL;
    for (int y = 0; y < frame.height; ++y) {
        const std::uint8_t* row = frame.row(y);
        int x = 0;
        for (; x + 8 <= frame.width; x += 8) {
            std::uint64_t eight = 0;
            std::memcpy(&eight, row + x, sizeof eight);
            sum = (sum ^ eight) * 0x9fb21c651e98df25ULL;
            sum ^= sum >> 29U;
        }
        for (; x < frame.width; ++x) sum = mix64(sum ^ row[x]);
    }
    if (sum != last_) {
        last_ = sum;
        since_ = time;
    }
    return to_seconds(time - since_);
}

}  // namespace roomfix
