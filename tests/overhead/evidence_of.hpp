// What a camera shows of bodies, for tests that need no rendered picture.
#pragma once

#include <cmath>
#include <utility>
#include <vector>

#include "roomfix/imaging/evidence.hpp"
#include "roomfix/overhead/body.hpp"

namespace roomfix {

/// What a camera of 640 x 480 px shows of bodies, with a gap across their middle: real ones are not as filled as their description.
inline Evidence evidence_of(const View& view, const std::vector<std::pair<Body, Pose2>>& bodies) {
    Evidence evidence;
    evidence.width = 640;
    evidence.height = 480;
    evidence.pixels.assign(640 * 480, {0, Evidence::certain});
    BodyMask mask;
    for (const auto& [body, pose] : bodies) {
        cover(view, body.parts, pose, 640, 480, 1, 1, mask);
        for (const Span& span : mask.spans) {
            const bool gap = std::abs(span.y - (mask.top + mask.bottom) / 2) < (mask.bottom - mask.top) / 20;
            for (int x = span.begin; x < span.end && !gap; ++x) evidence.pixels[static_cast<std::size_t>(span.y * 640 + x)] = {Evidence::certain, 0};
        }
    }
    evidence.sum_up();
    return evidence;
}

}  // namespace roomfix
