// How fast evidence may decide between association hypotheses.
#pragma once

#include <vector>

#include "roomfix/base/time.hpp"

namespace roomfix {

/// What is wrong in one frame is so in the next, too: evidence turns a balance by so many nats a second only.
class Conviction {
public:
    /// Weights after some evidence, with their differences as far as they may count. `before`: of the same alternatives.
    void temper(const std::vector<double>& before, std::vector<double>& after, Nanoseconds time, double nats_per_second);

private:
    double nats_ = 0;  // by which evidence may still turn the balance ...
    Nanoseconds told_ = 0;
};

}  // namespace roomfix
