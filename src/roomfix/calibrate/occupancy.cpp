#include "roomfix/calibrate/occupancy.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "roomfix/calibrate/prism.hpp"
#include "roomfix/geometry/convex_hull.hpp"
#include "roomfix/overhead/silhouette.hpp"

namespace roomfix {
namespace {

/// Is a place in one of the prisms?
bool hold(const std::vector<Prism>& prisms, const Eigen::Vector3d& p) {
    return std::any_of(prisms.begin(), prisms.end(),
                       [&](const Prism& prism) { return p.z() >= prism.low && p.z() <= prism.high && inside_polygon(prism.hull, p.head<2>(), 0); });
}

ConvexPart slab(const std::vector<Eigen::Vector2d>& hull, double low, double high) {
    ConvexPart part;
    for (const double z : {low, high}) {
        for (const Eigen::Vector2d& p : hull) part.points.emplace_back(p.x(), p.y(), z);
    }
    return part;
}

/// At most so many corners: those farthest out in evenly spread directions.
std::vector<Eigen::Vector2d> simplified(const std::vector<Eigen::Vector2d>& hull) {
    constexpr int most = 20;
    if (hull.size() <= most) return hull;
    std::vector<Eigen::Vector2d> kept;
    for (int i = 0; i < most; ++i) {
        const double angle = 2 * std::numbers::pi * i / most;
        const Eigen::Vector2d direction(std::cos(angle), std::sin(angle));
        kept.push_back(*std::max_element(hull.begin(), hull.end(), [&](const auto& a, const auto& b) { return a.dot(direction) < b.dot(direction); }));
    }
    return hull_of(kept);
}

}  // namespace

Occupancy::Occupancy(const std::vector<BodyMoment>& moments, const std::vector<BodySight>& sights, const Body& rough, bool round,
                     const OccupancySettings& settings)
    : settings_(settings), round_(round) {
    reach_ = rough.radius * (1 + settings.margin);
    cell_ = 2 * rough.radius / settings.cells_across;
    across_ = static_cast<int>(std::ceil(2 * reach_ / cell_));
    reach_ = 0.5 * across_ * cell_;
    layer_ = rough.height / settings.cells_up;
    up_ = static_cast<int>(std::ceil(rough.height * (1 + settings.margin_up) / layer_));
    log_odds_.assign(static_cast<std::size_t>(across_ * across_ * up_), 0.0);
    seen_.assign(log_odds_.size(), {});
    std::vector<Prism> prisms;
    for (const ConvexPart& part : rough.parts) prisms.push_back(prism_of(part));
    for (int z = 0; z < up_; ++z) {
        for (int y = 0; y < across_; ++y) {
            for (int x = 0; x < across_; ++x) {
                const Eigen::Vector3d p = middle(x, y, z);
                before_.push_back(hold(prisms, p) ? 0 : settings.beyond);
                for (const BodySight& sight : sights) {
                    const double c = std::cos(sight.pose.yaw);
                    const double s = std::sin(sight.pose.yaw);
                    const Eigen::Vector3d map(sight.pose.x + c * p.x() - s * p.y(), sight.pose.y + s * p.x() + c * p.y(), p.z());
                    for (const SeenBy& camera : moments[sight.moment].cameras) {
                        const Evidence& evidence = *camera.evidence;
                        const auto pixel = project_map_point(*camera.view, map);
                        if (!pixel) continue;
                        const double u = (pixel->x() + 0.5) / evidence.scale;
                        const double v = (pixel->y() + 0.5) / evidence.scale;
                        if (!(u >= 0 && v >= 0 && u < evidence.width && v < evidence.height)) continue;
                        const Evidence::Sums seen = evidence.run(static_cast<int>(v), static_cast<int>(u), static_cast<int>(u) + 1);
                        Evidence::Sums& sums = seen_[index(x, y, z)];
                        sums.other += seen.other;
                        sums.plain += seen.plain;
                    }
                }
            }
        }
    }
    if (round) make_round();
    for (int z = 0; z < up_; ++z) weigh_layer(z);
}

/// How much of the body differs from the background is not the same at all heights (a coat like the wall behind it), nor is what lies around
/// it: both parts and the cells' odds are estimated in turns.
void Occupancy::weigh_layer(int z) {
    constexpr int rounds = 8;
    constexpr double least_contrast = 0.15;  // between the two parts: with less, this height tells nothing
    const std::size_t first = index(0, 0, z);
    const std::size_t last = index(0, 0, z + 1);
    double filled = settings_.filled;
    double passing = settings_.passing;
    for (int i = 0; i < rounds; ++i) {
        const double as_body = std::log(filled / passing);
        const double as_nothing = std::log((1 - filled) / (1 - passing));
        Evidence::Sums inside{static_cast<float>(settings_.weight * settings_.filled), static_cast<float>(settings_.weight * (1 - settings_.filled))};
        Evidence::Sums outside{static_cast<float>(settings_.weight * settings_.passing), static_cast<float>(settings_.weight * (1 - settings_.passing))};
        for (std::size_t c = first; c < last; ++c) {
            log_odds_[c] = before_[c] + as_body * static_cast<double>(seen_[c].other) + as_nothing * static_cast<double>(seen_[c].plain);
            // In the first round the rough body says what is inside.
            Evidence::Sums& sums = (i == 0 ? before_[c] == 0 : log_odds_[c] > 0) ? inside : outside;
            sums.other += seen_[c].other;
            sums.plain += seen_[c].plain;
        }
        passing = std::clamp(static_cast<double>(outside.other / (outside.other + outside.plain)), 0.02, 0.8);
        filled = std::clamp(static_cast<double>(inside.other / (inside.other + inside.plain)), passing + least_contrast, 0.97);
    }
}

/// Each ring gets its mean.
void Occupancy::make_round() {
    const int rings = across_;
    for (int z = 0; z < up_; ++z) {
        std::vector<Evidence::Sums> sums(static_cast<std::size_t>(rings));
        std::vector<float> counts(static_cast<std::size_t>(rings), 0.0f);
        const auto ring = [&](int x, int y) { return std::min(rings - 1, static_cast<int>(middle(x, y, z).head<2>().norm() / cell_)); };
        for (int y = 0; y < across_; ++y) {
            for (int x = 0; x < across_; ++x) {
                Evidence::Sums& sum = sums[static_cast<std::size_t>(ring(x, y))];
                sum.other += seen_[index(x, y, z)].other;
                sum.plain += seen_[index(x, y, z)].plain;
                ++counts[static_cast<std::size_t>(ring(x, y))];
            }
        }
        for (int y = 0; y < across_; ++y) {
            for (int x = 0; x < across_; ++x) {
                const auto r = static_cast<std::size_t>(ring(x, y));
                seen_[index(x, y, z)] = {sums[r].other / counts[r], sums[r].plain / counts[r]};
            }
        }
    }
}

std::vector<Eigen::Vector2d> Occupancy::layer_hull(int z) const {
    std::vector<Eigen::Vector2d> corners;
    if (round_) {
        // Only what is connected with the axis; where the ring beyond begins to be empty, the cell's part says where.
        double radius = 0;
        for (int x = across_ / 2; x < across_ && at(x, across_ / 2, z) > 0; ++x) radius = (x + 1) * cell_ - reach_;
        constexpr int sides = 12;
        const double r = radius * (1 + 0.25 * std::pow(std::numbers::pi / sides, 2));
        for (int i = 0; i < sides && radius > 0; ++i) {
            corners.emplace_back(r * std::cos(2 * std::numbers::pi * i / sides), r * std::sin(2 * std::numbers::pi * i / sides));
        }
        return corners;
    }
    for (int y = 0; y < across_; ++y) {
        for (int x = 0; x < across_; ++x) {
            if (at(x, y, z) <= 0) continue;
            // A single cell without neighbours is no body.
            int near = 0;
            for (int dy = -1; dy <= 1; ++dy) {
                for (int dx = -1; dx <= 1; ++dx) {
                    const int nx = x + dx, ny = y + dy;
                    near += nx >= 0 && ny >= 0 && nx < across_ && ny < across_ && at(nx, ny, z) > 0;
                }
            }
            if (near < 5) continue;
            const Eigen::Vector2d p = middle(x, y, z).head<2>();
            for (const double sx : {-0.5, 0.5}) {
                for (const double sy : {-0.5, 0.5}) corners.emplace_back(p.x() + sx * cell_, p.y() + sy * cell_);
            }
        }
    }
    return corners.size() < 4 ? std::vector<Eigen::Vector2d>() : simplified(hull_of(corners));
}

std::vector<ConvexPart> Occupancy::parts() const {
    struct Piece {
        std::vector<Eigen::Vector2d> hull;
        double volume = 0;      // of the layers' own hulls, in cells' heights
        int low = 0, high = 0;  // layers, high exclusive
    };
    std::vector<Piece> pieces;
    for (int z = 0; z < up_; ++z) {
        auto hull = layer_hull(z);
        if (hull.size() < 3) continue;
        const double area = polygon_area(hull);
        if (area < 2 * cell_ * cell_) continue;
        pieces.push_back({std::move(hull), area, z, z + 1});
    }
    // The two neighbours whose common hull is least larger than their own are joined, until all are much larger and there are few enough.
    const auto joined = [](const Piece& a, const Piece& b) {
        std::vector<Eigen::Vector2d> all = a.hull;
        all.insert(all.end(), b.hull.begin(), b.hull.end());
        return Piece{simplified(hull_of(all)), a.volume + b.volume, a.low, b.high};
    };
    while (pieces.size() > 1) {
        double least = 1e9;
        std::size_t which = 0;
        for (std::size_t i = 0; i + 1 < pieces.size(); ++i) {
            const Piece both = joined(pieces[i], pieces[i + 1]);
            const double growth = polygon_area(both.hull) * (both.high - both.low) / both.volume;
            if (growth < least) {
                least = growth;
                which = i;
            }
        }
        if (least > settings_.least_growth && pieces.size() <= settings_.most_parts) break;
        pieces[which] = joined(pieces[which], pieces[which + 1]);
        pieces.erase(pieces.begin() + static_cast<std::ptrdiff_t>(which) + 1);
    }
    std::vector<ConvexPart> parts;
    for (const Piece& piece : pieces) parts.push_back(slab(piece.hull, piece.low * layer_, piece.high * layer_));
    return parts;
}

double Occupancy::size_sigma() const {
    constexpr double surely = 3;  // log odds
    double open = 0;
    double surface = 0;
    for (int z = 0; z < up_; ++z) {
        for (int y = 1; y + 1 < across_; ++y) {
            for (int x = 1; x + 1 < across_; ++x) {
                open += std::abs(at(x, y, z)) < surely;
                surface += (at(x, y, z) > 0) != (at(x + 1, y, z) > 0);
                surface += (at(x, y, z) > 0) != (at(x, y + 1, z) > 0);
            }
        }
    }
    // A cell of thickness counts at least half: nothing is finer than the grid.
    return 0.5 * cell_ * std::max(0.5, surface > 0 ? 0.5 * open / surface : 1.0);
}

}  // namespace roomfix
