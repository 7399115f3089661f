// The papers' methods as published, for single pictures: the baselines that ours are compared with.
#pragma once

#include <optional>
#include <vector>

#include "roomfix/ceiling/kim2011.hpp"
#include "roomfix/corner/chou1986.hpp"
#include "roomfix/overhead/li2014.hpp"
#include "roomfix/pipeline/camera/camera_kind.hpp"

namespace roomfix {

/// Li 2014: a fixed camera. It states no uncertainty; that of its own Table 1 is given.
class PublishedFixed {
public:
    /// An error if the camera does not see the floor ahead of it. `empty`: frames without robots.
    static Result<PublishedFixed> create(const View& view, const std::vector<LumaImage>& empty);
    /// The site's first robot.
    Sighting look(LumaView frame);

private:
    explicit PublishedFixed(Li2014 method) : method_(std::move(method)) {}
    Li2014 method_;
};

/// Kim 2011: a camera that looks up to a landmark of three LEDs. It states no uncertainty; that of its own Table 1 is given.
class PublishedOnboard {
public:
    /// An error if `hints.landmark`, or without it the site's first one, is no triangle of LEDs.
    static Result<PublishedOnboard> create(const Site& site, const SiteCamera& camera, int robot, const FrameHints& hints);
    Sighting look(LumaView frame, const FrameHints& hints);

private:
    PublishedOnboard(const Site& site, const SiteCamera& camera, int robot, int landmark);
    int robot_;
    int beacon_ = -1;    // at the landmark; -1: none
    double height_ = 0;  // m, of the landmark above the robot's receiver
    Kim2011 method_;
};

/// Chou 1986: the corner as the paper finds it; which one it is, our locator says. It states no uncertainty; its experiment is off by up to 5 %.
class PublishedCorner {
public:
    explicit PublishedCorner(const CameraModel& model) : method_(model) {}
    CornerResult look(LumaView frame);

private:
    Chou1986 method_;
};

}  // namespace roomfix
