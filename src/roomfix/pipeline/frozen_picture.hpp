// Notices a camera that sends the same picture again and again.
#pragma once

#include <cstdint>

#include "roomfix/base/time.hpp"
#include "roomfix/imaging/luma.hpp"

namespace roomfix {

/// Real sensors are never still: noise makes every picture different.
class FrozenPicture {
public:
    /// Seconds for which this very picture has been coming, 0 for a new one. One pass over the picture.
    double seconds(LumaView frame, Nanoseconds time);

private:
    std::uint64_t last_ = 0;
    Nanoseconds since_ = 0;
};

constexpr double frozen_after = 0.45;  // s of the same picture

}  // namespace roomfix
