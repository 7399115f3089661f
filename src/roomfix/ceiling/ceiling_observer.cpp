#include "roomfix/ceiling/ceiling_observer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace roomfix {

CeilingObserver::CeilingObserver(const CameraOnRobot& camera, bool mount_calibrated, const std::vector<SiteLandmark>& landmarks,
                                 const CeilingSettings& settings)
    : camera_(camera), settings_(settings) {
    const double focal = 0.5 * (camera.model.fx + camera.model.fy);
    const double known_tilt = 4 * std::sqrt(camera.robot_from_camera.covariance.bottomRightCorner<3, 3>().trace());
    const double tilt = mount_calibrated ? std::max(known_tilt, 1e-3) : settings.unknown_tilt;
    // A tilt stretches lengths most where the view is most oblique.
    const double oblique = std::hypot(camera.model.width, camera.model.height) / (2 * focal);
    const double stretch = tilt * (1 + 2 * oblique);
    const auto shapes = landmark_shapes(landmarks);
    for (std::size_t i = 0; i < shapes.size(); ++i) {
        const auto* triangle = std::get_if<LedTriangle>(&shapes[i].kind);
        const double rise = shapes[i].height - camera.robot_from_camera.pose.translation().z();
        if (!triangle || rise <= 0) continue;
        const double pixel = rise / focal;  // m
        Shape shape{static_cast<int>(i), shapes[i].height, {triangle->a, triangle->b, 3 * settings.rough_sigma * pixel, stretch}, 0, {}};
        shape.largest_misfit = settings.largest_misfit + 0.5 * stretch * std::hypot(triangle->a, triangle->b) / pixel;
        const auto own = own_points(shapes[i].kind);
        for (std::size_t k = 0; k < 3; ++k) shape.own[k] = own[k].head<2>();
        shapes_.push_back(shape);
    }
}

void CeilingObserver::observe(LumaView frame, CeilingResult& result) {
    result.landmarks.clear();
    result.rejected.clear();
    result.reason.clear();
    find_spots(frame);
    find_candidates();
    for (const Candidate& candidate : candidates_) {
        const auto taken = [&](int spot) { return spots_[static_cast<std::size_t>(spot)].used; };
        if (std::any_of(candidate.match.spots.begin(), candidate.match.spots.end(), taken)) continue;
        LandmarkObservation observation;
        if (!verify(frame, candidate, observation)) continue;
        for (const int spot : candidate.match.spots) spots_[static_cast<std::size_t>(spot)].used = true;
        result.landmarks.push_back(observation);
    }
    for (const Spot& spot : spots_) {
        if (!spot.used) result.rejected.push_back({spot.centroid.cast<float>()});
    }
    if (result.landmarks.empty()) result.reason = reason_for_nothing(result);
}

/// Small bright blobs and their centroids.
void CeilingObserver::find_spots(LumaView frame) {
    find_bright_spots(frame, settings_.bright, mask_);
    spots_.clear();
    // Largest first; what is too large is no LED.
    for (const Component& blob : finder_.find(mask_, 1)) {
        if (blob.area > settings_.largest_blob) continue;
        if (static_cast<int>(spots_.size()) == settings_.most_spots) break;
        const auto centroid = spot_centroid(frame, blob.centroid, settings_.rough_radius);
        if (centroid && (*centroid - blob.centroid).norm() < settings_.fit.radius) spots_.push_back({*centroid, false, {}, false});
    }
}

/// Triples of spots with the sides of a landmark, the best first.
void CeilingObserver::find_candidates() {
    candidates_.clear();
    for (std::size_t s = 0; s < shapes_.size(); ++s) {
        places_.clear();
        for (const Spot& spot : spots_) {
            const auto place = point_at_height(camera_, spot.centroid, shapes_[s].height);
            places_.push_back(place.value_or(Eigen::Vector2d(1e6, 1e6)));
        }
        matches_.clear();
        find_triangles(places_, shapes_[s].triangle, matches_);
        for (const TriangleMatch& match : matches_) candidates_.push_back({match, s});
    }
    std::sort(candidates_.begin(), candidates_.end(), [](const Candidate& a, const Candidate& b) { return a.match.misfit < b.match.misfit; });
}

const std::optional<SpotFit>& CeilingObserver::fitted(LumaView frame, int index) {
    Spot& spot = spots_[static_cast<std::size_t>(index)];
    if (!spot.fitted) {
        spot.fitted = true;
        spot.fit = fit_spot(frame, spot.centroid, settings_.fit);
    }
    return spot.fit;
}

/// Three clean spots of like brightness on a dark ground, at the landmark's distances.
bool CeilingObserver::verify(LumaView frame, const Candidate& candidate, LandmarkObservation& observation) {
    const Shape& shape = shapes_[candidate.shape];
    std::array<SpotFit, 3> fits;
    std::array<Eigen::Vector2d, 3> places;
    double noise = 0;
    for (std::size_t i = 0; i < 3; ++i) {
        const auto& fit = fitted(frame, candidate.match.spots[i]);
        if (!fit || fit->width < settings_.narrowest || fit->width > settings_.widest) return false;
        if (fit->noise > settings_.largest_noise) return false;
        const auto place = point_at_height(camera_, fit->centre, shape.height);
        if (!place) return false;
        fits[i] = *fit;
        places[i] = *place;
        noise += fit->noise / 3;
    }
    const auto light = [](const SpotFit& f) { return f.amplitude * f.width * f.width; };
    const auto [least, most] = std::minmax({light(fits[0]), light(fits[1]), light(fits[2])});
    if (most > settings_.largest_ratio * least) return false;
    if (!dark_between(frame, fits)) return false;

    // As if the landmark lay in the map's origin: the misfit does not depend on where it is.
    const Pose2 pose = align(places, shape.own);
    double squares = 0;
    for (std::size_t i = 0; i < 3; ++i) {
        const auto pixel = predict_point(camera_, pose, Eigen::Vector3d(shape.own[i].x(), shape.own[i].y(), shape.height));
        if (!pixel) return false;
        squares += (fits[i].centre - *pixel).squaredNorm();
    }
    if (std::sqrt(squares / 6) > shape.largest_misfit) return false;

    // A camera's noise stays what it is: the mean over the last frames knows it better than one frame's few pixels do.
    noise_ += (noise - noise_) / std::min(++noise_frames_ + 1, settings_.noise_memory);
    const double scale = std::max({noise_, 0.5 * noise, settings_.least_noise});
    const double model_variance = settings_.model_sigma * settings_.model_sigma;
    for (const SpotFit& fit : fits) observation.points.push_back({fit.centre, fit.covariance * scale + model_variance * Eigen::Matrix2d::Identity()});
    observation.shapes.push_back(shape.index);
    return true;
}

/// The landmark's panel is darker than its LEDs on all three sides.
bool CeilingObserver::dark_between(LumaView frame, const std::array<SpotFit, 3>& fits) const {
    for (std::size_t i = 0; i < 3; ++i) {
        const SpotFit& a = fits[i];
        const SpotFit& b = fits[(i + 1) % 3];
        const double peak = std::min(a.peak, b.peak);
        for (const double part : {0.4, 0.5, 0.6}) {
            const Eigen::Vector2d p = a.centre + part * (b.centre - a.centre);
            if (static_cast<double>(sample(frame, static_cast<float>(p.x()), static_cast<float>(p.y()))) > peak - settings_.least_contrast) return false;
        }
    }
    return true;
}

std::string CeilingObserver::reason_for_nothing(const CeilingResult& result) const {
    if (shapes_.empty()) return "the site has no landmark of LEDs above the camera";
    if (result.rejected.empty()) return "no small bright spot in the picture";
    if (result.rejected.size() < 3) return fmt::format("{} bright spot{}, a landmark has three: is a LED dead or outside the picture?", result.rejected.size(), result.rejected.size() == 1 ? "" : "s");
    return fmt::format("{} bright spots, but no three at a landmark's distances: is a LED dead or outside the picture?", result.rejected.size());
}

}  // namespace roomfix
