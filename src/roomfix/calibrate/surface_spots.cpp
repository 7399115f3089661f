#include "roomfix/calibrate/surface_spots.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "roomfix/calibrate/prism.hpp"
#include "roomfix/overhead/silhouette.hpp"

namespace roomfix {
namespace {

double surface_of(const Prism& prism) {
    double around = 0;
    for (std::size_t i = 0; i < prism.hull.size(); ++i) around += (prism.hull[(i + 1) % prism.hull.size()] - prism.hull[i]).norm();
    return polygon_area(prism.hull) + around * (prism.high - prism.low);
}

bool inside_another(const std::vector<Prism>& prisms, const Prism& own, const Eigen::Vector3d& p) {
    return std::any_of(prisms.begin(), prisms.end(), [&](const Prism& other) {
        return &other != &own && p.z() > other.low - 1e-6 && p.z() < other.high - 1e-6 && inside_polygon(other.hull, p.head<2>(), 0);
    });
}

/// The colours of one spot in all its sights.
struct SpotSights {
    std::array<double, 3> sum{};
    double squares = 0;  // of all channels' deviations from the mean
    double other = 0, plain = 0;
    int sights = 0;
};

/// One camera's picture of one sight.
struct Sight {
    const Evidence* evidence = nullptr;
    std::vector<SeenSpot> seen;
    ToneChange tone;
};

}  // namespace

std::vector<LookSpot> spots_on(const std::vector<ConvexPart>& parts, int about) {
    std::vector<Prism> prisms;
    double surface = 0;
    for (const ConvexPart& part : parts) {
        prisms.push_back(prism_of(part));
        surface += surface_of(prisms.back());
    }
    const double step = std::sqrt(surface / std::max(about, 1));
    std::vector<LookSpot> spots;
    const auto add = [&](const Prism& prism, const Eigen::Vector3d& place, const Eigen::Vector3d& outwards) {
        if (inside_another(prisms, prism, place)) return;
        LookSpot spot;
        spot.place = place.cast<float>();
        spot.outwards = outwards.cast<float>();
        spots.push_back(spot);
    };
    for (const Prism& prism : prisms) {
        Eigen::Vector2d low = Eigen::Vector2d::Constant(1e9), high = -low;
        for (const Eigen::Vector2d& p : prism.hull) {
            low = low.cwiseMin(p);
            high = high.cwiseMax(p);
        }
        for (double y = low.y() + step / 2; y < high.y(); y += step) {
            for (double x = low.x() + step / 2; x < high.x(); x += step) {
                if (inside_polygon(prism.hull, {x, y}, 0)) add(prism, {x, y, prism.high}, Eigen::Vector3d::UnitZ());
            }
        }
        const int rows = std::max(1, static_cast<int>(std::lround((prism.high - prism.low) / step)));
        for (std::size_t i = 0; i < prism.hull.size(); ++i) {
            const Eigen::Vector2d from = prism.hull[i];
            const Eigen::Vector2d along = prism.hull[(i + 1) % prism.hull.size()] - from;
            const int columns = std::max(1, static_cast<int>(std::lround(along.norm() / step)));
            const Eigen::Vector3d outwards = Eigen::Vector3d(along.y(), -along.x(), 0).normalized();
            for (int row = 0; row < rows; ++row) {
                const double z = prism.low + (prism.high - prism.low) * (row + 0.5) / rows;
                for (int column = 0; column < columns; ++column) {
                    const Eigen::Vector2d p = from + along * (column + 0.5) / columns;
                    add(prism, {p.x(), p.y(), z}, outwards);
                }
            }
        }
    }
    return spots;
}

BodyLook look_from(const std::vector<BodyMoment>& moments, const std::vector<BodySight>& sights, const std::vector<LookSpot>& spots, bool round,
                   const SpotSettings& settings) {
    BodyLook look;
    look.spots = spots;
    std::vector<Sight> pictures;
    for (const BodySight& sight : sights) {
        for (const SeenBy& camera : moments[sight.moment].cameras) {
            if (camera.evidence->colours.empty()) continue;
            Sight picture{camera.evidence, {}, {}};
            see_spots(*camera.view, *camera.evidence, look, sight.pose, settings.look, picture.seen);
            if (picture.seen.empty()) continue;
            look.channels = std::min(look.channels, camera.evidence->channels);
            pictures.push_back(std::move(picture));
        }
    }
    const auto channels = static_cast<std::size_t>(look.channels);
    const auto channel = [&](const Sight& picture, std::size_t pixel, std::size_t k) {
        const float* colour = picture.evidence->colours.data() + pixel * static_cast<std::size_t>(picture.evidence->channels);
        if (look.channels == picture.evidence->channels) return static_cast<double>(colour[k]);
        return static_cast<double>(colour[0] + colour[1] + colour[2]) / 3;
    };
    // Spots of a round body that share their height and direction share their colour.
    std::vector<std::size_t> kind(spots.size());
    std::map<std::pair<long, long>, std::size_t> kinds;
    for (std::size_t i = 0; i < spots.size(); ++i) {
        const std::pair<long, long> key = {std::lround(1e4 * static_cast<double>(spots[i].place.z())),
                                           std::lround(10 * static_cast<double>(spots[i].outwards.z()))};
        kind[i] = round ? kinds.emplace(key, kinds.size()).first->second : i;
    }
    std::vector<SpotSights> sums;
    constexpr int rounds = 3;  // the light on the robot depends on its colours, and they on the light
    for (int i = 0; i < rounds; ++i) {
        sums.assign(spots.size(), {});
        for (const Sight& picture : pictures) {
            for (const SeenSpot& s : picture.seen) {
                SpotSights& sum = sums[kind[s.spot]];
                const Evidence::Sums pixel = picture.evidence->at(s.pixel);
                sum.other += static_cast<double>(pixel.other);
                sum.plain += static_cast<double>(pixel.plain);
                ++sum.sights;
                for (std::size_t k = 0; k < channels; ++k) sum.sum[k] += picture.tone.undone(channel(picture, s.pixel, k));
            }
        }
        for (std::size_t spot = 0; spot < spots.size(); ++spot) {
            const SpotSights& sum = sums[kind[spot]];
            for (std::size_t k = 0; k < channels && sum.sights > 0; ++k) look.spots[spot].colour[k] = static_cast<float>(sum.sum[k] / sum.sights);
        }
        if (i + 1 == rounds || pictures.size() < 2) break;
        for (Sight& picture : pictures) {
            picture.tone = tone_on(*picture.evidence, look, picture.seen, settings.look);
            picture.tone.light = std::clamp(picture.tone.light, -1.0, 1.0);
        }
    }
    for (const Sight& picture : pictures) {
        for (const SeenSpot& s : picture.seen) {
            for (std::size_t k = 0; k < channels; ++k) {
                const double off = picture.tone.undone(channel(picture, s.pixel, k)) - static_cast<double>(look.spots[s.spot].colour[k]);
                sums[kind[s.spot]].squares += off * off;
            }
        }
    }
    std::vector<LookSpot> kept;
    for (std::size_t spot = 0; spot < spots.size(); ++spot) {
        const SpotSights& sum = sums[kind[spot]];
        if (sum.sights == 0 || sum.other + 0.5 < settings.least_filled * (sum.other + sum.plain + 1)) continue;
        const double first = settings.first_sights * settings.first_sigma * settings.first_sigma;
        const double variance = (sum.squares / static_cast<double>(channels) + first) / (sum.sights + settings.first_sights);
        look.spots[spot].sigma = static_cast<float>(std::max(std::sqrt(variance), settings.least_sigma));
        kept.push_back(look.spots[spot]);
    }
    look.spots = std::move(kept);
    return look;
}

}  // namespace roomfix
