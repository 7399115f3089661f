#include "roomfix/calibrate/tile_grid.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace roomfix {
namespace {

constexpr double step = 0.25;         // px between the samples of a profile
constexpr int farthest_tile = 80;     // from the first one, in each direction
constexpr double least_contrast = 3;  // grey levels between joint and tiles
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

/// How far across the joint's middle is from where it should be, px; `sign` +1 for joints darker than the tiles, -1 for lighter ones.
std::optional<double> read_joint(LumaView picture, const Place& place, double reach, int sign) {
    const int half = static_cast<int>(std::ceil((reach + 2.5) / step));
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
    for (double& v : profile) v *= sign / static_cast<double>(rows);
    const int near = static_cast<int>(reach / step);
    const auto darkest = std::min_element(profile.begin() + half - near, profile.begin() + half + near + 1) - profile.begin();
    // The tiles' levels on both sides may differ: the joint is what lies below the line between them.
    const auto side = static_cast<std::ptrdiff_t>(2.5 / step);
    const auto last = static_cast<std::ptrdiff_t>(profile.size()) - 1;
    if (darkest - side < 0 || darkest + side > last) return std::nullopt;
    const double left = profile[static_cast<std::size_t>(darkest - side)], right = profile[static_cast<std::size_t>(darkest + side)];
    double sum = 0, moment = 0;
    for (std::ptrdiff_t i = darkest - side; i <= darkest + side; ++i) {
        const double level = left + (right - left) * static_cast<double>(i - darkest + side) / static_cast<double>(2 * side);
        const double depth = std::max(level - profile[static_cast<std::size_t>(i)], 0.0);
        sum += depth;
        moment += depth * static_cast<double>(i);
    }
    if (std::min(left, right) - profile[static_cast<std::size_t>(darkest)] < least_contrast) return std::nullopt;
    return (moment / sum - half) * step;
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
    double doubt = settings.reading_sigma;
    for (const Place& place : places) {
        if (sightings.size() == most) break;
        const auto offset = read_joint(picture, place, reach_of(place), sign);
        if (!offset) continue;
        doubt = std::max(doubt, 0.5 * place.sigma);
        sightings.push_back({place.pixel + *offset * place.normal, place.map, place.normal * place.normal.transpose()});
    }
    for (FloorSighting& s : sightings) s.information /= doubt * doubt;
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
