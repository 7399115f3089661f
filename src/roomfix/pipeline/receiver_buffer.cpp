#include "roomfix/pipeline/receiver_buffer.hpp"

#include <algorithm>
#include <cmath>

namespace roomfix {

ReceiverBuffer::ReceiverBuffer(const Site& site) {
    for (const SiteRobot& robot : site.robots) robots_.push_back({!robot.receivers.empty(), {}});
}

void ReceiverBuffer::keep(const RangeObservation& range) {
    Received& robot = robots_[static_cast<std::size_t>(range.robot)];
    if (!robot.has_receiver) return;
    std::erase_if(robot.newest, [&](const RangeObservation& old) { return old.beacon == range.beacon && old.receiver == range.receiver; });
    robot.newest.push_back(range);
}

std::vector<RangeObservation> ReceiverBuffer::near(int robot, Nanoseconds time) const {
    constexpr double longest_age = 0.3;  // s: ranges that old still belong together
    std::vector<RangeObservation> near;
    for (const RangeObservation& range : robots_[static_cast<std::size_t>(robot)].newest) {
        if (std::abs(to_seconds(time - range.time)) < longest_age) near.push_back(range);
    }
    return near;
}

}  // namespace roomfix
