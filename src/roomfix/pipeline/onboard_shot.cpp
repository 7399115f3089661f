#include <fmt/format.h>

#include <cmath>
#include <memory>

#include "roomfix/base/number.hpp"
#include "roomfix/ceiling/kim2011.hpp"
#include "roomfix/ceiling/lamps.hpp"
#include "roomfix/connect/overlay.hpp"
#include "roomfix/connect/range_source.hpp"
#include "roomfix/pipeline/onboard_locator.hpp"
#include "roomfix/pipeline/single_shot.hpp"

namespace roomfix {
namespace {

/// A camera on a robot: landmarks, and the ranges of the moment.
class OnboardShot {
public:
    OnboardShot(const Site& site, const SiteCamera& camera, std::unique_ptr<OnboardLocator> locator)
        : site_(site), camera_(camera), locator_(std::move(locator)) {}

    Result<void> use_landmark(const std::string& id) {
        for (std::size_t i = 0; i < site_.landmarks.size(); ++i) {
            if (site_.landmarks[i].id == id) landmark_ = static_cast<int>(i);
        }
        if (landmark_ < 0) return Error{fmt::format("--landmark {}: the site has no such landmark", id)};
        return {};
    }
    Result<void> use_ranges(const std::string& file, const std::function<void(const std::string&)>& note) {
        auto batch = load_ranges(file, site_, locator_->robot());
        if (!batch) return batch.error();
        for (const std::string& problem : batch->problems) note(problem);
        ranges_ = std::move(batch->ranges);
        return {};
    }
    Result<void> use_published() {
        const int index = landmark_ >= 0 ? landmark_ : 0;
        if (site_.landmarks.empty() || !std::holds_alternative<LedTriangle>(site_.landmarks[static_cast<std::size_t>(index)].kind)) {
            return Error{"the published method needs a landmark of three LEDs: add one, or choose it by --landmark"};
        }
        published_landmark_ = index;
        published_ = std::make_unique<Kim2011>(site_.landmarks[static_cast<std::size_t>(index)], std::get<Mount>(camera_.placement));
        return {};
    }

    std::vector<Fix> fixes(const std::string& image, LumaView frame) {
        const auto stamp = parse_integer(std::filesystem::path(image).stem().string());
        const auto ranges = ranges_around(ranges_, locator_->robot(), stamp);
        locator_->locate(&frame, ranges, std::nullopt, landmark_, result_);
        if (published_) return {published_fix(image, frame, ranges)};
        std::vector<std::string> sources = {camera_.id};
        if (!ranges.empty()) sources.emplace_back("ranges");
        Fix fix = locator_->fix_of(result_, stamp.value_or(0), sources);
        fix.image = image;
        return {fix};
    }
    Result<void> overlay(const std::filesystem::path& file, LumaView frame) const {
        CeilingOverlay drawn;
        drawn.landmarks = result_.seen.landmarks;
        drawn.names = locator_->landmark_names(result_);
        for (const RejectedSpot& spot : result_.seen.rejected) drawn.rejected.push_back(spot.pixel);
        for (const LampBox& lamp : find_lamps(frame)) drawn.lamps.push_back({lamp.left, lamp.top, lamp.right, lamp.bottom});
        drawn.caption = result_.located.reason;
        if (!result_.located.places.empty()) {
            const RobotPlace& place = result_.located.places[0];
            drawn.caption = fmt::format("x {:.3f} m, y {:.3f} m, yaw {:.1f} deg, +- {:.1f} mm", place.pose.x, place.pose.y, degrees(place.pose.yaw),
                                        1e3 * std::sqrt(place.covariance(0, 0) + place.covariance(1, 1)));
        }
        return save_ceiling_overlay(file, frame, drawn);
    }

private:
    Fix published_fix(const std::string& image, LumaView frame, const std::vector<RangeObservation>& ranges) {
        const SiteLandmark& landmark = site_.landmarks[static_cast<std::size_t>(published_landmark_)];
        const SiteRobot& robot = site_.robots[static_cast<std::size_t>(locator_->robot())];
        std::optional<double> distance;
        for (const RangeObservation& range : ranges) {
            if (site_.beacons[static_cast<std::size_t>(range.beacon)].id == landmark.beacon) distance = range.range;
        }
        const double height = landmark.map_from_landmark.translation().z() - (robot.receiver() ? robot.receiver()->position.z() : 0);
        std::string reason;
        const auto found = published_->locate(frame, distance, height, &reason);
        if (!found) return empty_fix(image, reason);
        Fix fix = empty_fix(image, "");
        fix.status = FixStatus::ok;
        fix.robot = robot.id;
        fix.pose = found->pose;
        // The paper gives no uncertainty; its own Table 1 has 2.3 cm rms.
        fix.covariance = Eigen::Vector3d(0.016 * 0.016, 0.016 * 0.016, 0.02 * 0.02).asDiagonal();
        fix.sources = {camera_.id};
        return fix;
    }

    Site site_;
    SiteCamera camera_;
    std::unique_ptr<OnboardLocator> locator_;
    OnboardResult result_;
    std::vector<RangeObservation> ranges_;
    std::unique_ptr<Kim2011> published_;
    int landmark_ = -1;
    int published_landmark_ = 0;
};

}  // namespace

Result<Shot> prepare_onboard_shot(const Site& site, const SiteCamera& camera, const ShotOptions& options) {
    auto locator = OnboardLocator::for_camera(site, camera);
    if (!locator) return locator.error();
    const auto onboard = std::make_shared<OnboardShot>(site, camera, std::move(*locator));
    if (!options.landmark.empty()) {
        if (auto used = onboard->use_landmark(options.landmark); !used) return used.error();
    }
    if (!options.ranges.empty()) {
        if (auto used = onboard->use_ranges(options.ranges, options.note); !used) return used.error();
    }
    if (options.published) {
        if (auto used = onboard->use_published(); !used) return used.error();
    }
    Shot shot;
    shot.model = camera.model;
    shot.fixes = [onboard](const std::string& image, const PictureView& frame) { return onboard->fixes(image, frame.grey); };
    shot.overlay = [onboard](const std::filesystem::path& file, LumaView frame) { return onboard->overlay(file, frame); };
    return shot;
}

}  // namespace roomfix
