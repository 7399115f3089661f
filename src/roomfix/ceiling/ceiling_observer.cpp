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

/// Each spot by itself; then those that a lamp's glare spoils again, with what the clean ones tell.
std::optional<CeilingObserver::Leds> CeilingObserver::fit_leds(LumaView frame, const TriangleMatch& match) {
    Leds leds;
    std::array<bool, 3> clean;
    const SpotFit* model = nullptr;  // the clean one, or the dimmest: glare makes spots look brighter
    bool model_clean = false;
    for (std::size_t i = 0; i < 3; ++i) {
        const auto& fit = fitted(frame, match.spots[i]);
        const bool known_width = width_ == 0 || (fit && std::abs(fit->width - width_) < 0.2 * width_);
        clean[i] = fit && fit->noise < settings_.suspicious_noise * noise_ && known_width;
        if (!fit) continue;
        leds.fits[i] = *fit;
        const bool better = !model || (clean[i] != model_clean ? clean[i] : fit->amplitude < model->amplitude);
        if (better) {
            model = &leds.fits[i];
            model_clean = clean[i];
        }
    }
    if (!model) return std::nullopt;
    const SpotPrior prior{.width = width_ > 0 ? width_ : model->width, .amplitude = model->amplitude};
    SpotFitSettings narrow = settings_.fit;
    narrow.reach = settings_.glare_reach;
    for (std::size_t i = 0; i < 3; ++i) {
        if (clean[i]) continue;
        const auto again = fit_spot(frame, spots_[static_cast<std::size_t>(match.spots[i])].centroid, narrow, &prior);
        if (!again) return std::nullopt;
        leds.fits[i] = *again;
        leds.extra_sigma[i] = settings_.glare_sigma;
    }
    return leds;
}

/// Clean spots of like brightness on a dark ground.
bool CeilingObserver::look_like_leds(LumaView frame, const Leds& leds) const {
    for (const SpotFit& fit : leds.fits) {
        if (fit.width < settings_.narrowest || fit.width > settings_.widest || fit.noise > settings_.largest_noise) return false;
    }
    const auto light = [](const SpotFit& f) { return f.amplitude * f.width * f.width; };
    const auto [least, most] = std::minmax({light(leds.fits[0]), light(leds.fits[1]), light(leds.fits[2])});
    return most <= settings_.largest_ratio * least && dark_between(frame, leds.fits);
}

/// As if the landmark lay in the map's origin: the misfit does not depend on where it is.
bool CeilingObserver::at_distances(const Shape& shape, const Leds& leds) const {
    std::array<Eigen::Vector2d, 3> places;
    for (std::size_t i = 0; i < 3; ++i) {
        const auto place = point_at_height(camera_, leds.fits[i].centre, shape.height);
        if (!place) return false;
        places[i] = *place;
    }
    const Pose2 pose = align(places, shape.own);
    double squares = 0;
    for (std::size_t i = 0; i < 3; ++i) {
        const auto pixel = predict_point(camera_, pose, Eigen::Vector3d(shape.own[i].x(), shape.own[i].y(), shape.height));
        if (!pixel) return false;
        squares += (leds.fits[i].centre - *pixel).squaredNorm();
    }
    return std::sqrt(squares / 6) < shape.largest_misfit;
}

bool CeilingObserver::verify(LumaView frame, const Candidate& candidate, LandmarkObservation& observation) {
    const Shape& shape = shapes_[candidate.shape];
    const auto leds = fit_leds(frame, candidate.match);
    if (!leds || !look_like_leds(frame, *leds) || !at_distances(shape, *leds)) return false;
    double noise = 0;
    int clean = 0;
    double width = 0;
    for (std::size_t i = 0; i < 3; ++i) {
        if (leds->extra_sigma[i] > 0) continue;
        ++clean;
        noise += leds->fits[i].noise;
        width += leds->fits[i].width;
    }
    if (clean > 0) {
        const double part = 1.0 / std::min(++frames_known_ + 1, settings_.noise_memory);
        noise_ += part * (noise / clean - noise_);
        width_ = width_ == 0 ? width / clean : width_ + part * (width / clean - width_);
    }
    for (std::size_t i = 0; i < 3; ++i) {
        const double scale = std::max({noise_, 0.5 * leds->fits[i].noise, settings_.least_noise});
        const double sigma = std::hypot(settings_.model_sigma, leds->extra_sigma[i]);
        observation.points.push_back({leds->fits[i].centre, leds->fits[i].covariance * scale + sigma * sigma * Eigen::Matrix2d::Identity()});
    }
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
    if (result.rejected.size() < 3)
        return fmt::format("{} bright spot{}, a landmark has three: is a LED dead or outside the picture?", result.rejected.size(),
                           result.rejected.size() == 1 ? "" : "s");
    return fmt::format("{} bright spots, but no three at a landmark's distances: is a LED dead or outside the picture?", result.rejected.size());
}

}  // namespace roomfix
