#include "roomfix/overhead/exactness.hpp"

#include <algorithm>
#include <cmath>

namespace roomfix {

Exactness::Exactness(std::size_t kinds, const OverheadSettings& settings)
    : settings_(settings), own_(kinds, 0.0), to_others_(kinds, 0.0), described_(kinds, settings.described) {}

bool Exactness::holds_for(std::size_t kind, double nats) const { return of(kind) + std::max(nats - settings_.exact_at_once, 0.0) > settings_.surely_exact; }

void Exactness::note(std::size_t kind, double nats) { own_[kind] = std::clamp(own_[kind] + nats, -settings_.most_exact, settings_.most_exact); }

void Exactness::note_outline(std::size_t kind, double nats) { note(kind, std::clamp(nats, -settings_.exact_at_once, settings_.exact_at_once)); }

double Exactness::described(std::size_t kind) const { return 1 / (1 + std::exp(-described_[kind])); }

/// In some of the frames something else was found.
void Exactness::note_description(std::size_t kind, double likelihood) {
    const double nats = std::log(settings_.surely_robot * likelihood + 1 - settings_.surely_robot);
    described_[kind] = std::clamp(described_[kind] + std::min(nats, settings_.described_at_once), -settings_.most_exact, settings_.most_exact);
}

}  // namespace roomfix
