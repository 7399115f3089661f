// Are robots the very solids that the site file describes? That shows over many frames; one in which a robot is partly hidden says little.
#pragma once

#include <vector>

#include "roomfix/overhead/overhead_settings.hpp"

namespace roomfix {

/// All of a kind of robot (robots that look alike), in nats.
class Exactness {
public:
    Exactness(std::size_t kinds, const OverheadSettings& settings);

    /// That it is the very solid, as this camera saw robots of its kind, and as others did.
    double own(std::size_t kind) const { return own_[kind]; }
    void set_to_others(std::size_t kind, double nats) { to_others_[kind] = nats; }
    /// Of both together.
    bool is_sure(std::size_t kind) const { return of(kind) > settings_.surely_exact; }
    /// Are outlines worth looking for?
    bool may_be(std::size_t kind) const { return of(kind) > -settings_.surely_exact; }
    /// Is this outline that of the very solid? `nats`: for it, of this outline alone.
    bool holds_for(std::size_t kind, double nats) const;
    void note(std::size_t kind, double nats);
    /// The same of one outline, which may tell only so much.
    void note_outline(std::size_t kind, double nats);

    /// That its outlines are about as described: probability.
    double described(std::size_t kind) const;
    /// `likelihood`: how much likelier a robot as described is to show the edges that were seen than anything else.
    void note_description(std::size_t kind, double likelihood);

private:
    double of(std::size_t kind) const { return own_[kind] + to_others_[kind]; }

    OverheadSettings settings_;
    std::vector<double> own_, to_others_;
    std::vector<double> described_;
};

}  // namespace roomfix
