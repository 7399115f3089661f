// Which stated sigmas of robots' own senses a recording shows to be too small.
#pragma once

#include <string>
#include <vector>

#include "roomfix/estimate/tracker.hpp"
#include "roomfix/site/site.hpp"

namespace roomfix {

/// One number of the site file.
struct SigmaAdvice {
    std::string robot;  // id
    std::string sense;  // odometry, detector, or a receiver: "receiver", or "receivers.ID"
    std::string key;    // such as scale_sigma
    double stated = 0;  // as the site has it, or its default
    double found = 0;   // what it should be
};

/// What a tracker learned of the senses of robots that these found, where it is clearly more than stated. A sentence each: text_of().
std::vector<SigmaAdvice> sigma_advice(const Tracker& tracker);
std::string text_of(const SigmaAdvice& advice);

/// The robot with those that are about it.
SiteRobot advised(SiteRobot robot, const std::vector<SigmaAdvice>& advice);

}  // namespace roomfix
