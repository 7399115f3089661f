// What is wrong with the inputs of a robot's own senses: units, sides, clocks, beacons that are not where the site says.
#pragma once

#include <string>
#include <vector>

#include "roomfix/estimate/tracker.hpp"
#include "roomfix/pipeline/recorded_senses.hpp"
#include "roomfix/site/site.hpp"

namespace roomfix {

/// Odometry whose units cannot be right, whatever else is known: a sentence with the cure, or nothing.
std::string wrong_units(const std::vector<OdometryObservation>& odometry, const SiteRobot& robot);

/// After a recording: what about the inputs of `robot` is other than the site and the formats say, as sentences with the cure. Where the tracker
/// got on well with them nothing is looked at. Otherwise each likely mistake is undone in turn, and one is told if all that was sensed is
/// clearly more likely without it: the densities of the observations as the tracker expected them are compared.
std::vector<std::string> suspicions(const Tracker& tracker, int robot, const Senses& senses);

}  // namespace roomfix
