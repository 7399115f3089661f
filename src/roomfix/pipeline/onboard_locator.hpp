// What a robot carries, at work: a camera that sees landmarks, a receiver that hears beacons, or both, to the robot's place.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "roomfix/base/result.hpp"
#include "roomfix/ceiling/ceiling_observer.hpp"
#include "roomfix/ceiling/robot_locator.hpp"
#include "roomfix/estimate/event.hpp"
#include "roomfix/imaging/tag_detector.hpp"
#include "roomfix/observation/fix.hpp"
#include "roomfix/observation/pose_observation.hpp"

namespace roomfix {

/// What one moment shows, for the fix and for drawing.
struct OnboardResult {
    CeilingResult seen;
    LocatedRobot located;
};

/// Places as the tracker takes them: where it may start.
std::vector<PlaceProposal> proposals_of(const std::vector<RobotPlace>& places);

class OnboardLocator {
public:
    /// An error if the camera is not mounted on a robot of the site.
    static Result<std::unique_ptr<OnboardLocator>> for_camera(const Site& site, const SiteCamera& camera);
    /// Ranges alone. An error if the robot has no receiver.
    static Result<std::unique_ptr<OnboardLocator>> for_ranges(const Site& site, int robot);

    int robot() const { return robot_; }
    /// `frame` may be missing (ranges alone). `ranges`: of this robot, about as old as the frame. `expected`: where the tracker thinks
    /// it is. `landmark`: index of the one that is seen, if it is known, or -1.
    void locate(const LumaView* frame, std::span<const RangeObservation> ranges, const std::optional<PoseObservation>& expected, int landmark,
                OnboardResult& result);

    /// The names of the landmarks that the best place rests on, one per observation ("" where it explains none).
    std::vector<std::string> landmark_names(const OnboardResult& result) const;
    /// The points that the best place rests on.
    std::vector<SeenPoint> seen_points(const OnboardResult& result) const;
    /// The result as fixes: one, with all places as hypotheses where there are several.
    Fix fix_of(const OnboardResult& result, Nanoseconds time, const std::vector<std::string>& sources) const;

private:
    explicit OnboardLocator(const Site& site, int robot) : site_(site), robot_(robot) {}
    void add_tags(LumaView frame, std::vector<LandmarkObservation>& landmarks);

    Site site_;
    int robot_;
    std::optional<CeilingObserver> observer_;
    std::optional<TagDetector> tags_;
    std::vector<LandmarkShape> shapes_;
    std::vector<SeenTag> seen_tags_;
    std::unique_ptr<RobotLocator> locator_;
};

}  // namespace roomfix
