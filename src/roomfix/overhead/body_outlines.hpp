// The outlines of robots that were found by their bodies: exact to a fraction of a pixel where a robot is the solid that the site file describes, and telling
// a robot that is about as described from other things.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "roomfix/overhead/body_observer.hpp"
#include "roomfix/overhead/exactness.hpp"
#include "roomfix/overhead/found_outline.hpp"

namespace roomfix {

/// Keeps its memory between frames.
class BodyOutlines {
public:
    BodyOutlines(const View& view, std::shared_ptr<const RobotShapes> shapes, const OverheadSettings& settings);

    /// The outline of a robot that was found by its body; nothing where it has not that exact outline. What it shows goes into `exactness`.
    /// `standing`: all robots that were found; nearer ones may hide it.
    std::optional<SilhouetteObservation> at(const FrameEvidence& evidence, const BodySighting& sighting, std::span<const KnownRobot> standing,
                                            const BodyObserver& bodies, const Expectation& expected, Exactness& exactness);

    /// Nats by which the edges speak for a robot where its body was found, and not for something else of about its size. They say nothing of robots that
    /// are badly described.
    double edges_for(const FrameEvidence& evidence, const BodySighting& sighting, std::span<const KnownRobot> standing, const BodyObserver& bodies,
                     const Expectation& expected, const Exactness& exactness);

private:
    void set_nearer(const BodySighting& sighting, std::span<const KnownRobot> standing);
    std::optional<OutlineFit> fit_near(const FrameEvidence& evidence, int robot, const BodyPlace& place, bool sure, const PoseObservation* expected);
    std::optional<OutlineFit> best_fit(const FrameEvidence& evidence, const BodySighting& sighting, bool sure, const PoseObservation* expected);
    std::optional<OutlineFit> exact_outline_of_parts(const FrameEvidence& evidence, const BodySighting& sighting);
    void try_outlines(const FrameEvidence& evidence, const BodySighting& sighting, const Expectation& expected);
    void fit_parts(const FrameEvidence& evidence, const BodyPlace& place, const Eigen::Vector2d& aside, double yaw);
    double likelihood_of_edges() const;
    SilhouetteObservation weighed_outlines(const BodySighting& sighting, const BodyObserver& bodies) const;

    View view_;
    std::shared_ptr<const RobotShapes> shapes_;
    OverheadSettings settings_;
    // Working memory.
    std::vector<Silhouette> others_;  // what stands nearer to the camera than a robot
    std::vector<ShapePoints> rough_;  // the parts of a robot, less exact than described
    std::vector<OutlineFit> turned_;  // its outline at all poses that were tried, the likeliest first
};

}  // namespace roomfix
