// A robot found by its outline, before it becomes an observation: does the outline convince?
#pragma once

#include <span>
#include <vector>

#include "roomfix/observation/silhouette_observation.hpp"
#include "roomfix/overhead/overhead_settings.hpp"
#include "roomfix/overhead/robot_search.hpp"

namespace roomfix {

/// What outlines the robots of a site have.
struct RobotShapes {
    RobotShapes(const std::vector<SiteRobot>& all_robots, const BodyObserverSettings& settings);

    std::vector<SiteRobot> robots;
    std::vector<ShapePoints> whole;               // of each robot, then of things that are no robots
    std::vector<std::vector<ShapePoints>> parts;  // of each robot: those whose outline may be fitted

    const ShapePoints& of(int robot) const { return whole[static_cast<std::size_t>(robot)]; }
    const std::vector<ShapePoints>& parts_of(int robot) const { return parts[static_cast<std::size_t>(robot)]; }
};

struct FoundOutline {
    int robot = 0;
    CoarsePose coarse;
    OutlineFit fit;
    bool removed = false;  // its pixels are no longer among those to be explained
    bool by_area = false;  // soft target: found by its area, not by its outline
};

bool enough_in_view(const OutlineFit& fit, const OverheadSettings& settings);

/// Is it a fix?
bool acceptable(const FoundOutline& found, const OverheadSettings& settings);

/// How well an outline explains the picture: the edges that agree, and its area less what of it shows nothing.
double quality(const FoundOutline& found);

/// Could the lower edge that the fit found be the border of the robot's shadow, and the robot stand farther in?
bool may_stand_behind(const FrameEvidence& evidence, const View& view, std::span<const ShapePoints> parts, const OutlineFit& fit,
                      const OverheadSettings& settings);

/// As an observation of one camera. `body`: the robot's.
SilhouetteObservation observation_of(const FoundOutline& found, const RobotShapes& shapes, const Body& body, const View& view);

}  // namespace roomfix
