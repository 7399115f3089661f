// Whose turn it is to be searched for: searches of the whole view take long, so that they come only so often and one at a time.
#pragma once

#include <optional>

#include "roomfix/base/time.hpp"
#include "roomfix/overhead/body_observer.hpp"

namespace roomfix {

/// Of one camera. By the times of its frames only, so that replay gives the same.
class SearchTurns {
public:
    /// What is searched for in the frame of this time. `others_outlines`: another camera of the same moment searches for outlines.
    void set(Nanoseconds time, bool others_outlines, Expectation& expected) {
        const auto since = [&](const std::optional<Nanoseconds>& last) { return last ? std::abs(to_seconds(time - *last)) : never_yet; };
        const bool slow = since(frame_) > 0.8 * interval;  // so few frames that each has to do everything
        frame_ = time;
        expected.search = since(bodies_) > interval;
        expected.search_outlines = since(outlines_) > interval && (slow || !(expected.search || others_outlines));
        if (expected.search) bodies_ = time;
        if (expected.search_outlines) outlines_ = time;
    }

private:
    static constexpr double interval = 0.29;  // s of frame time
    static constexpr double never_yet = 1e9;

    std::optional<Nanoseconds> frame_, bodies_, outlines_;
};

}  // namespace roomfix
