#include "roomfix/calibrate/tile_grid.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "roomfix/base/decompositions.hpp"

namespace roomfix {
namespace {

constexpr double step = 0.25;         // px between the samples of a profile
constexpr int farthest_tile = 80;     // from the first one, in each direction
constexpr double least_contrast = 3;  // grey levels between joint and tiles
constexpr double clear_depth = 5;     // standard deviations
constexpr double faintest = 0.4;      // px: joints whose middle is known no better tell nothing
constexpr double window_across = 3;   // px to either side of a joint that its middle is found from
constexpr double samples_along = 5;   // px to either side along the joint that a profile is the mean of

/// A place on a joint: where it should be, and across which direction it can be measured.
struct Place {
    Eigen::Vector2d map;
    Eigen::Vector2d pixel;
    Eigen::Vector2d normal;  // unit, px
    double pitch = 0;        // px, to the next parallel joint
    double sigma = 0;        // px across, of the prediction
};

/// px across in which the joint must be.
double reach_of(const Place& place) { return 3 * place.sigma + 1; }

Eigen::Vector2d on_map(const TileGrid& grid, const Eigen::Vector2d& tiles) {
    const Pose2& p = grid.map_from_grid;
    return Eigen::Vector2d(p.x, p.y) + Eigen::Rotation2Dd(p.yaw) * (grid.size * tiles);
}

/// A place half-way between two crossings: `tiles` in tiles, the joint runs along `along`.
std::optional<Place> place_on(const View& view, const TileGrid& grid, const Eigen::Vector2d& tiles, const Eigen::Vector2d& along) {
    Place place;
    place.map = on_map(grid, tiles);
    ViewJacobian j;
    const auto pixel = project_map_point(view, {place.map.x(), place.map.y(), 0}, &j);
    if (!pixel || !view.model.contains(*pixel, 8)) return std::nullopt;
    place.pixel = *pixel;
    const Eigen::Rotation2Dd turn(grid.map_from_grid.yaw);
    const Eigen::Vector2d tangent = j.by_point.leftCols<2>() * (turn * along);
    if (tangent.norm() * grid.size < 2 * samples_along) return std::nullopt;  // too short in the picture
    place.normal = Eigen::Vector2d(-tangent.y(), tangent.x()).normalized();
    place.pitch = std::abs(place.normal.dot(j.by_point.leftCols<2>() * (turn * Eigen::Vector2d(-along.y(), along.x())))) * grid.size;
    const Eigen::RowVectorXd by = place.normal.transpose() * j.by_pose;
    place.sigma = std::sqrt(std::max((by * view.map_from_camera.covariance * by.transpose())(0, 0), 0.0));
    return place;
}

/// The mean light along a joint on lines beside it, every `step` px from `-half` steps to `half` steps across. Nothing at the picture's rim.
std::optional<std::vector<double>> profile_across(LumaView picture, const Place& place, int half) {
    std::vector<double> profile(static_cast<std::size_t>(2 * half + 1), 0);
    const Eigen::Vector2d tangent(place.normal.y(), -place.normal.x());
    int rows = 0;
    for (double along = -samples_along; along <= samples_along; along += 1, ++rows) {
        for (int i = -half; i <= half; ++i) {
            const Eigen::Vector2d p = place.pixel + along * tangent + i * step * place.normal;
            if (p.x() < 1 || p.y() < 1 || p.x() > picture.width - 3 || p.y() > picture.height - 3) return std::nullopt;
            profile[static_cast<std::size_t>(i + half)] += static_cast<double>(sample(picture, static_cast<float>(p.x()), static_cast<float>(p.y())));
        }
    }
    for (double& v : profile) v /= rows;
    return profile;
}

/// A valley between two levels, all as blurred as the valley is wide: level + contrast erf(t) - depth exp(-t^2), t = (x - middle) / width.
/// The tiles' levels on both sides differ by chance: whatever takes that for a part of the joint finds it nearer to the darker tile.
struct Valley {
    double middle = 0;   // px
    double width = 1;    // px
    double depth = 0;    // grey levels; negative for a joint that is lighter than the tiles
    double sigma = 0;    // px, of the middle, from what the fit leaves
    bool clear = false;  // the depth stands out of what the fit leaves
};

/// The unknowns of a valley as they are fitted.
enum ValleyNumber { valley_level, valley_contrast, depth, middle, width, valley_numbers };
using ValleyVector = Eigen::Matrix<double, valley_numbers, 1>;
using ValleyMatrix = Eigen::Matrix<double, valley_numbers, valley_numbers>;

/// Pixels around a place on a joint, to its middle as it is known before.
struct Window {
    const Place& place;
    double across = 0;  // px from the place
    int left = 0, top = 0, right = -1, bottom = -1;

    Window(const Place& at, double middle_across) : place(at), across(middle_across) {
        const Eigen::Vector2d centre = place.pixel + across * place.normal;
        const Eigen::Vector2d reach = window_across * place.normal.cwiseAbs() + samples_along * tangent().cwiseAbs();
        left = static_cast<int>(std::ceil(centre.x() - reach.x())), right = static_cast<int>(centre.x() + reach.x());
        top = static_cast<int>(std::ceil(centre.y() - reach.y())), bottom = static_cast<int>(centre.y() + reach.y());
    }
    Eigen::Vector2d tangent() const { return {place.normal.y(), -place.normal.x()}; }
    bool inside(LumaView picture) const { return left >= 0 && top >= 0 && right < picture.width && bottom < picture.height; }
};

struct ValleyFit {
    ValleyMatrix information = ValleyMatrix::Zero();
    ValleyVector pull = ValleyVector::Zero();
    double squares = 0;
    int pixels = 0;
};

ValleyFit linearise(LumaView picture, const Window& window, const ValleyVector& n) {
    ValleyFit fit;
    const Eigen::Vector2d tangent = window.tangent();
    for (int y = window.top; y <= window.bottom; ++y) {
        const std::uint8_t* line = picture.row(y);
        for (int x = window.left; x <= window.right; ++x) {
            const Eigen::Vector2d off = Eigen::Vector2d(x, y) - window.place.pixel;
            const double across = window.place.normal.dot(off);
            if (std::abs(across - window.across) > window_across || std::abs(tangent.dot(off)) > samples_along) continue;
            const double t = (across - n[middle]) / n[width], bell = std::exp(-t * t), edge = std::erf(t);
            const double by_t = n[valley_contrast] * 2 * std::numbers::inv_sqrtpi * bell + n[depth] * 2 * t * bell;
            const ValleyVector by(1, edge, -bell, -by_t / n[width], -by_t * t / n[width]);
            const double residual = line[x] - n[valley_level] - n[valley_contrast] * edge + n[depth] * bell;
            fit.information += by * by.transpose();
            fit.pull += residual * by;
            fit.squares += residual * residual;
            ++fit.pixels;
        }
    }
    return fit;
}

/// Fits a valley to the pixels around a place, not to what lies between them: joints are narrower than a pixel. `start.middle` is across from the place.
std::optional<Valley> fit_valley(LumaView picture, const Place& place, const Valley& start) {
    constexpr double narrowest = 0.5, widest = 3, farthest = 1.5;  // px
    constexpr int rounds = 12;
    const Window window(place, start.middle);
    if (!window.inside(picture)) return std::nullopt;
    ValleyVector n(0, 0, start.depth, start.middle, start.width);
    ValleyFit fit;
    for (int round = 0; round < rounds; ++round) {
        fit = linearise(picture, window, n);
        ValleyMatrix damped = fit.information;
        if (round == 0) damped.bottomRightCorner<2, 2>().diagonal().array() += 1e12;  // the levels first: they are linear
        damped.diagonal() *= 1 + 1e-6;
        const ValleyVector way = damped.ldlt().solve(fit.pull);
        if (!way.allFinite()) return std::nullopt;
        n += way;
        n[width] = std::clamp(n[width], narrowest, widest);
        if (std::abs(n[middle] - start.middle) > farthest) return std::nullopt;
        if (round > 0 && std::abs(way[middle]) < 1e-4) break;
    }
    const double variance = fit.squares / std::max(fit.pixels - static_cast<int>(valley_numbers), 1);
    const ValleyMatrix covariance = variance * fit.information.inverse();
    if (!covariance.allFinite() || !(covariance(middle, middle) > 0)) return std::nullopt;
    const bool clear = n[depth] * n[depth] > clear_depth * clear_depth * covariance(depth, depth);
    return Valley{n[middle], n[width], n[depth], std::sqrt(covariance(middle, middle)), clear};
}

/// The joint, if there is one within `reach` px of where it should be; `sign` +1 for joints darker than the tiles, -1 for lighter ones.
std::optional<Valley> read_joint(LumaView picture, const Place& place, double reach, int sign) {
    const int window = static_cast<int>(std::ceil(window_across / step)), near = static_cast<int>(reach / step);
    const int half = near + window;
    const auto profile = profile_across(picture, place, half);
    if (!profile) return std::nullopt;
    const auto lower = [&](double a, double b) { return sign * a < sign * b; };
    const auto predicted = profile->begin() + half;
    const auto darkest = std::min_element(predicted - near, predicted + near + 1, lower);
    const double rise = std::min(sign * (*(darkest - window) - *darkest), sign * (*(darkest + window) - *darkest));
    if (rise < least_contrast) return std::nullopt;
    const auto at = static_cast<double>(darkest - predicted) * step;
    const auto valley = fit_valley(picture, place, {at, 1, sign * rise});
    if (!valley || !valley->clear || sign * valley->depth < least_contrast || valley->sigma > faintest) return std::nullopt;
    return valley;
}

/// Places on all joints that can be told apart from their neighbours; those that are known best come first.
std::vector<Place> places_in(const View& view, const TileGrid& grid, const TileGridSettings& settings) {
    std::vector<Place> places;
    for (int i = -farthest_tile; i <= farthest_tile; ++i) {
        for (int k = -farthest_tile; k <= farthest_tile; ++k) {
            for (const bool across : {false, true}) {
                for (const double part : {0.3, 0.5, 0.7}) {
                    const Eigen::Vector2d tiles = across ? Eigen::Vector2d(i, k + part) : Eigen::Vector2d(i + part, k);
                    const auto place = place_on(view, grid, tiles, across ? Eigen::Vector2d::UnitY() : Eigen::Vector2d::UnitX());
                    if (place && place->pitch > settings.least_pitch && reach_of(*place) < 0.35 * place->pitch) places.push_back(*place);
                }
            }
        }
    }
    std::stable_sort(places.begin(), places.end(), [](const Place& a, const Place& b) { return a.sigma < b.sigma; });
    return places;
}

/// Reads the first places until `most` joints were found. While the camera is known badly, all of them are off together: that is no reason
/// to doubt one.
std::vector<FloorSighting> read_joints(LumaView picture, const std::vector<Place>& places, int sign, std::size_t most, const TileGridSettings& settings) {
    std::vector<FloorSighting> sightings;
    std::vector<double> variances;
    double doubt = settings.reading_sigma;
    for (const Place& place : places) {
        if (sightings.size() == most) break;
        const auto joint = read_joint(picture, place, reach_of(place), sign);
        if (!joint) continue;
        doubt = std::max(doubt, 0.5 * place.sigma);
        sightings.push_back({place.pixel + joint->middle * place.normal, place.map, place.normal * place.normal.transpose()});
        variances.push_back(joint->sigma * joint->sigma);
    }
    for (std::size_t i = 0; i < sightings.size(); ++i) sightings[i].information /= doubt * doubt + variances[i];
    return sightings;
}

}  // namespace

FloorSource find_tile_grid(LumaView picture, const View& about, const TileGrid& grid, const std::vector<FloorSource>& sources,
                           const TileGridSettings& settings) {
    FloorSource joints{"tile grid", {}, {}, grid.size_sigma / grid.size, {grid.map_from_grid.x, grid.map_from_grid.y}, 0, true};
    View view = about;
    // Whether joints are dark or light shows near the first tile.
    const auto first = places_in(view, grid, settings);
    const auto seen_as = [&](int sign) {
        return read_joints(picture, {first.begin(), first.begin() + std::min<std::ptrdiff_t>(60, std::ssize(first))}, sign, 60, settings).size();
    };
    const int sign = seen_as(1) >= seen_as(-1) ? 1 : -1;
    std::size_t before = 0;
    for (std::size_t most = settings.first_joints; most < settings.most_joints; most *= 2) {
        joints.sightings = read_joints(picture, places_in(view, grid, settings), sign, most, settings);
        for (int round = 0; round < 2; ++round) {  // once more from the better place
            auto all = sources;
            all.push_back(joints);
            const auto found = calibrate_floor(view.model, IntrinsicsMatrix::Zero(), all, view.map_from_camera);
            if (!found) return {"tile grid", {}, {}, 0, {}, 0, true};
            view.map_from_camera = found->map_from_camera;
            joints.sightings = read_joints(picture, places_in(view, grid, settings), sign, most, settings);
        }
        if (joints.sightings.size() < most && joints.sightings.size() <= before + before / 50) break;  // there are no more
        before = joints.sightings.size();
    }
    return joints;
}

FloorSource find_tile_grid_from_either(LumaView picture, const CameraModel& model, const FloorCalibration& known, const TileGrid& grid,
                                       const std::vector<FloorSource>& sources, UncertainPose3& start) {
    start = known.map_from_camera;
    FloorSource joints = find_tile_grid(picture, {model, start}, grid, sources);
    if (!known.rival) return joints;
    const UncertainPose3 other{*known.rival, known.map_from_camera.covariance};
    FloorSource others = find_tile_grid(picture, {model, other}, grid, sources);
    if (others.sightings.size() <= joints.sightings.size()) return joints;
    start = other;
    return others;
}

}  // namespace roomfix
