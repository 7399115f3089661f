// Robots found by their bodies in all fixed cameras that looked at the same moment: one slanting view says little along its ray, several do.
#pragma once

#include <string>
#include <vector>

#include "roomfix/pipeline/camera/fixed_camera.hpp"

namespace roomfix {

/// What several cameras show together.
struct JointSighting {
    std::string source;  // the cameras' names joined by "+"
    std::vector<PoseObservation> robots;
    std::vector<BodyPlace> things;           // what is no robot
    std::vector<AbsenceObservation> absent;  // robots that are not where they should be
};

class JointBodies {
public:
    explicit JointBodies(const Site& site) : robots_(site.robots), walls_(site.walls), observer_(site.robots) {}

    /// Robots of which none of the cameras has an outline beyond doubt. The cameras have looked at these frames of this moment; doubtful outlines
    /// that contradict what all cameras show together are taken back.
    JointSighting find(const std::vector<FixedCamera*>& cameras, const std::vector<LumaView>& frames, const Expectation& expected = {});

private:
    struct Outline;
    static bool agree(const std::vector<Outline>& outlines);
    static void set_late(const std::vector<double>& late, PoseObservation& robot);
    void compare_outlines(const std::vector<FixedCamera*>& cameras) const;
    void share_exactness(const std::vector<FixedCamera*>& cameras) const;

    std::vector<SiteRobot> robots_;
    std::vector<Polyline> walls_;
    BodyObserver observer_;
};

}  // namespace roomfix
