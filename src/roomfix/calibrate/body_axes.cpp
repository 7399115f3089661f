#include "roomfix/calibrate/body_axes.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "roomfix/base/median.hpp"

namespace roomfix {
namespace {

constexpr double eighth = std::numbers::pi / 4;

/// Mean squared difference of colours between spots and their mirror images; where there is no spot it counts as a large one.
double unlikeness(const BodyLook& look, const std::vector<const LookSpot*>& spots, const GroundLine& line, double near) {
    constexpr double most = 0.5;
    const Eigen::Vector2d along(std::cos(line.angle), std::sin(line.angle));
    const Eigen::Vector2d left(-along.y(), along.x());
    const auto channels = static_cast<std::size_t>(look.channels);
    double sum = 0;
    for (const LookSpot* spot : spots) {
        const Eigen::Vector2d p = spot->place.head<2>().cast<double>();
        const Eigen::Vector2d image = p - 2 * (p.dot(left) - line.offset) * left;
        const LookSpot* nearest = nullptr;
        double least = near * near;
        for (const LookSpot* other : spots) {
            const double distance =
                (other->place.head<2>().cast<double>() - image).squaredNorm() + std::pow(static_cast<double>(other->place.z() - spot->place.z()), 2);
            if (distance >= least || std::abs(other->outwards.z() - spot->outwards.z()) > 0.5f) continue;
            least = distance;
            nearest = other;
        }
        double off = most;
        if (nearest) {
            double squares = 0;
            for (std::size_t k = 0; k < channels; ++k) squares += std::pow(static_cast<double>(nearest->colour[k] - spot->colour[k]), 2);
            off = std::min(squares / static_cast<double>(channels), most);
        }
        sum += off;
    }
    return sum / static_cast<double>(spots.size());
}

/// The spots of a look that are compared, and how far apart they lie (m). None where they are too few.
struct ComparedSpots {
    std::vector<const LookSpot*> spots;
    double apart = 0;
};
ComparedSpots compared_spots(const BodyLook& look) {
    constexpr std::size_t enough = 250;
    constexpr std::size_t least = 40;
    ComparedSpots compared;
    if (look.spots.size() < least) return compared;
    const std::size_t step = look.spots.size() / enough + 1;
    for (std::size_t i = 0; i < look.spots.size(); i += step) compared.spots.push_back(&look.spots[i]);
    for (const LookSpot* spot : compared.spots) {
        float nearest = 1e9f;
        for (const LookSpot* other : compared.spots) nearest = std::min(nearest, other == spot ? 1e9f : (other->place - spot->place).squaredNorm());
        compared.apart += std::sqrt(static_cast<double>(nearest)) / static_cast<double>(compared.spots.size());
    }
    return compared;
}

}  // namespace

FootprintBox footprint_box(const std::vector<ConvexPart>& parts, double angle) {
    const Eigen::Rotation2Dd turn(-angle);
    FootprintBox box;
    for (const ConvexPart& part : parts) {
        for (const Eigen::Vector3d& p : part.points) {
            const Eigen::Vector2d q = turn * p.head<2>();
            box.low = box.low.cwiseMin(q);
            box.high = box.high.cwiseMax(q);
        }
    }
    return box;
}

GroundLine body_axis(const std::vector<ConvexPart>& parts, const BodyLook& look, double reach) {
    constexpr double independent = 40;     // spots that tell something of their own: neighbours are alike
    constexpr double sharpness = 20;       // nats per log of the box's area: hulls of a few pictures are off by some per cent
    constexpr double clearly = 0.7;        // of the usual unlikeness: only then the mirror's line is believed to lie beside the middle of the box
    constexpr double straight = 1e-3;      // nats per rad: where nothing tells
    constexpr double least_unlike = 1e-3;  // squared colours: noise
    const ComparedSpots compared = compared_spots(look);
    GroundLine best;
    double most = -1e18, smallest = 1e9;
    std::vector<double> all;  // unlikenesses
    const auto attempt = [&](double angle, double box_nats, double offset) {
        const double unlike = compared.spots.empty() ? 1 : std::max(unlikeness(look, compared.spots, {angle, offset}, 1.2 * compared.apart), least_unlike);
        all.push_back(unlike);
        const double nats = box_nats - 0.5 * independent * std::log(unlike);
        if (nats <= most) return;
        most = nats;
        smallest = unlike;
        best = {angle, offset};
    };
    // `angles` and `offs` steps to each side of a line.
    constexpr int offs = 4;
    const auto attempt_around = [&](GroundLine middle, int angles, double angle_step, double off_step) {
        for (int i = -angles; i <= angles; ++i) {
            const double angle = middle.angle + i * angle_step;
            const double box_nats = -sharpness * std::log(footprint_box(parts, angle).area()) - straight * std::abs(angle);
            for (int k = -offs; k <= offs; ++k) attempt(angle, box_nats, middle.offset + k * off_step);
        }
    };
    constexpr int coarse = 15, finer = 4;
    attempt_around({}, coarse, eighth / coarse, reach / offs);
    const double usual = median(all);
    attempt_around(best, finer, eighth / coarse / finer, reach / (offs * offs));
    if (smallest > clearly * usual) best.offset = footprint_box(parts, best.angle).middle().y();
    return best;
}

}  // namespace roomfix
