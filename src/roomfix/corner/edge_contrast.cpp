#include "roomfix/corner/edge_contrast.hpp"

#include <algorithm>
#include <cmath>

namespace roomfix {

PieceContrast mean_of(const EdgeContrasts& pieces, std::size_t first, std::size_t last) {
    PieceContrast mean;
    for (std::size_t i = first; i < last; ++i) {
        mean.contrast += pieces[i].weight * pieces[i].contrast;
        mean.weight += pieces[i].weight;
    }
    if (mean.weight > 0) mean.contrast /= mean.weight;
    return mean;
}

std::size_t pieces_before_change(const EdgeContrasts& pieces, double length, const ContrastChange& change) {
    const auto group = std::max(std::size_t{1}, static_cast<std::size_t>(std::lround(change.within / length)));
    for (std::size_t i = 1; i < pieces.size(); ++i) {
        const PieceContrast before = mean_of(pieces, i - std::min(i, group), i);
        const PieceContrast after = mean_of(pieces, i, std::min(i + group, pieces.size()));
        if (before.weight <= 0 || after.weight <= 0) continue;
        const double variance = 1 / before.weight + 1 / after.weight;
        const double difference = after.contrast - before.contrast;
        if (difference * difference < change.certain * change.certain * variance) continue;
        const bool plainer = std::abs(after.contrast) > change.plainer * std::abs(before.contrast);
        const bool turned = after.contrast * before.contrast < 0 && std::abs(after.contrast) > std::abs(before.contrast);
        if (plainer || turned) return i;
    }
    return pieces.size();
}

}  // namespace roomfix
