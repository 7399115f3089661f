#include "roomfix/overhead/found_outline.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace roomfix {

RobotShapes::RobotShapes(const std::vector<SiteRobot>& all_robots, const BodyObserverSettings& settings) : robots(all_robots) {
    for (const SiteRobot& robot : robots) {
        whole.push_back(shape_points(robot.shape, robot.many ? std::max(robot.size_sigma, soft_size) : robot.size_sigma));
        parts.push_back(robot.learned ? std::vector<ShapePoints>() : outline_parts(robot));
    }
    for (const Cylinder& thing : settings.things) whole.push_back(shape_points(thing, settings.things_sigma));
}

bool enough_in_view(const OutlineFit& fit, const OverheadSettings& settings) { return fit.visible >= settings.least_visible * fit.total; }

bool acceptable(const FoundOutline& found, const OverheadSettings& settings) {
    if (!found.fit.determined) return false;
    if (found.by_area) {
        const double in_picture = found.coarse.inside.area / std::max(polygon_area(found.coarse.silhouette.polygon()), 1.0);
        return in_picture > settings.least_in_picture && found.coarse.filled() > settings.least_filled &&
               found.coarse.inside.foreground > settings.least_left * found.coarse.inside.area &&
               found.coarse.inside.shadow < 0.8 * found.coarse.inside.foreground;
    }
    const OutlineFit& fit = found.fit;
    if (!enough_in_view(fit, settings)) return false;
    if (fit.score >= settings.least_score) return true;
    if (found.coarse.missing >= 0.15 * found.coarse.inside.foreground) return false;
    // Not the exact outline, such as tracks where the box should end, but the robot's whole area and nothing beside it.
    if (found.coarse.filled() >= settings.surely_filled && fit.supported >= 0.4 * fit.visible) return true;
    // Partly hidden: much of the outline is bare, but what shows agrees.
    const double shown = fit.visible - fit.bare - fit.ambiguous;
    return fit.supported >= settings.least_hidden * fit.visible && fit.supported >= 0.65 * shown;
}

double quality(const FoundOutline& found) { return found.fit.score + found.coarse.filled() - found.coarse.missing_part(); }

bool may_stand_behind(const FrameEvidence& evidence, const View& view, std::span<const ShapePoints> parts, const OutlineFit& fit,
                      const OverheadSettings& settings) {
    if (fit.into_shadow < settings.least_into_shadow) return false;
    const auto behind = pose_behind_shadow(evidence, view, parts, fit, settings.fit);
    return behind && fit_outline(evidence, view, parts, *behind, {}, settings.fit).score > fit.score - settings.least_lead;
}

SilhouetteObservation observation_of(const FoundOutline& found, const RobotShapes& shapes, const Body& body, const View& view) {
    const std::vector<ShapePoints>& parts = shapes.parts_of(found.robot);
    const ShapePoints& shape = shapes.robots[static_cast<std::size_t>(found.robot)].parts.empty() ? shapes.of(found.robot) : parts.front();
    const OutlineFit& fit = found.fit;
    SilhouetteObservation observation;
    observation.robot = found.robot;
    observation.pose = fit.pose;
    observation.covariance = fit.covariance;
    observation.by_calibration = fit.by_calibration;
    observation.yaw_known = !shape.round();
    observation.support = fit.visible > 0 ? static_cast<double>(fit.supported) / fit.visible : 0;
    observation.edges = fit.edges;
    observation.exact = fit.exact;
    observation.visible = fit.total > 0 ? static_cast<double>(fit.visible) / fit.total : 0;
    const int alike = shape.round() ? 1 : static_cast<int>(std::lround(2 * std::numbers::pi / shape.symmetry));
    observation.like_turns = alike;
    for (int i = 0; i < alike; ++i) {
        observation.hypotheses.push_back({{fit.pose.x, fit.pose.y, wrap_angle(fit.pose.yaw + i * shape.symmetry)}, 1.0 / alike});
    }
    if (parts.size() > 1) {
        for (const auto& corner : outline_of(view, body, fit.pose)) observation.outline.push_back(corner.cast<float>());
    } else {
        for (const auto& corner : fit.silhouette.polygon()) observation.outline.push_back(corner.cast<float>());
    }
    return observation;
}

}  // namespace roomfix
