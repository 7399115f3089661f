// A camera on a robot that looks for landmarks; the ranges that the robot hears at that moment tell like ones apart.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "roomfix/base/result.hpp"
#include "roomfix/ceiling/ceiling_observer.hpp"
#include "roomfix/ceiling/robot_locator.hpp"
#include "roomfix/connect/drawing.hpp"
#include "roomfix/imaging/colour_image.hpp"
#include "roomfix/imaging/tag_detector.hpp"
#include "roomfix/pipeline/camera/sighting.hpp"

namespace roomfix {

/// Adds the lamps of a frame to what is drawn into it, where lamps are shown. Apart from drawing(), since it takes milliseconds.
void add_lamps(Drawing& drawing, LumaView frame);

class LandmarkCamera {
public:
    /// An error if the camera is not mounted on a robot of the site.
    static Result<LandmarkCamera> create(const Site& site, const SiteCamera& camera);

    /// Index of the robot that carries it.
    int robot() const { return robot_; }
    void look(const PictureView& frame, const FrameHints& hints);
    Sighting sighting() const;
    Drawing drawing() const;

    /// All places that the last frame and the ranges allow.
    const LocatedRobot& located() const { return located_; }
    /// The points that the best place rests on.
    std::vector<SeenPoint> seen_points() const;

private:
    LandmarkCamera(const Site& site, const SiteCamera& camera, int robot, const Mount& mount);
    void add_tags(LumaView frame);
    std::string name_of(std::size_t observation) const;
    double late() const;

    Site site_;
    int robot_;
    double readout_;  // s
    int rows_;        // of its pictures
    CeilingObserver observer_;
    std::optional<TagDetector> detector_;
    std::vector<LandmarkShape> shapes_;
    RobotLocator locator_;
    // Of the last frame:
    CeilingResult seen_;
    std::vector<SeenTag> seen_tags_;
    LocatedRobot located_;
};

}  // namespace roomfix
