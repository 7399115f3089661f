#include "roomfix/calibrate/body_axes.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

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

}  // namespace

double crookedness(const std::vector<ConvexPart>& parts) {
    double smallest = 1e18;
    double best = 0;
    for (double angle = -eighth; angle < eighth; angle += eighth / 90) {
        const Eigen::Rotation2Dd turn(angle);
        Eigen::Vector2d low = Eigen::Vector2d::Constant(1e9), high = -low;
        for (const ConvexPart& part : parts) {
            for (const Eigen::Vector3d& p : part.points) {
                const Eigen::Vector2d q = turn * p.head<2>();
                low = low.cwiseMin(q);
                high = high.cwiseMax(q);
            }
        }
        const double area = (high - low).prod() * (1 + 1e-3 * std::abs(angle));
        if (area < smallest) {
            smallest = area;
            best = angle;
        }
    }
    return best;
}

std::optional<GroundLine> mirror_line(const BodyLook& look, double reach) {
    constexpr std::size_t enough = 250;  // spots
    constexpr std::size_t least = 40;
    constexpr double clearly = 0.7;  // of the usual unlikeness
    if (look.spots.size() < least) return std::nullopt;
    std::vector<const LookSpot*> spots;
    const std::size_t step = look.spots.size() / enough + 1;
    for (std::size_t i = 0; i < look.spots.size(); i += step) spots.push_back(&look.spots[i]);
    double apart = 0;  // m, between neighbours
    for (const LookSpot* spot : spots) {
        float nearest = 1e9f;
        for (const LookSpot* other : spots) nearest = std::min(nearest, other == spot ? 1e9f : (other->place - spot->place).squaredNorm());
        apart += std::sqrt(static_cast<double>(nearest)) / static_cast<double>(spots.size());
    }
    std::vector<double> all;
    GroundLine best;
    double smallest = 1e9;
    const auto attempt = [&](double angle, double offset) {
        const double here = unlikeness(look, spots, {angle, offset}, 1.2 * apart);
        if (here < smallest) {
            smallest = here;
            best = {angle, offset};
        }
        return here;
    };
    for (double angle = -eighth; angle <= eighth; angle += eighth / 15) {
        for (double offset = -reach; offset <= reach; offset += reach / 4) all.push_back(attempt(angle, offset));
    }
    const GroundLine coarse = best;
    for (double angle = -eighth / 15; angle <= eighth / 15; angle += eighth / 60) {
        for (double offset = -reach / 4; offset <= reach / 4; offset += reach / 16) attempt(coarse.angle + angle, coarse.offset + offset);
    }
    std::nth_element(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(all.size() / 2), all.end());
    if (smallest > clearly * all[all.size() / 2]) return std::nullopt;
    return best;
}

}  // namespace roomfix
