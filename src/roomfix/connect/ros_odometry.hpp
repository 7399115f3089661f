// What a robot's wheels report on a ROS 2 topic.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "roomfix/connect/odometry_source.hpp"
#include "roomfix/connect/ros_message.hpp"
#include "roomfix/connect/sender_clock.hpp"

namespace roomfix {

/// The pose on the floor that a message states in the frame that its wheels began in; an error says why it states none.
Result<Pose2> pose_of_wheels(const ros::Odometry& message);

/// Messages nav_msgs/msg/Odometry of one topic. The sender's clock is followed: times in what comes out are of ours.
class RosOdometry {
public:
    /// `robot`: index in the site, whose wheels they are.
    explicit RosOdometry(int robot) : robot_(robot) {}

    /// Any bytes as a message that arrived at this time of our clock; `steady`: s of a clock that only goes forward. One whose stamp is 0 is as old as its
    /// arrival.
    OdometryBatch read(std::span<const std::uint8_t> message, Nanoseconds arrival, double steady);
    /// How the sender's clock differs, and what was not used, in words.
    std::string told() const;

private:
    Result<OdometryObservation> report_of(std::span<const std::uint8_t> message, Nanoseconds arrival, double steady);

    int robot_;
    SenderClock clock_;
    bool stamped_ = true;     // the last message had a time
    long not_used_ = 0;       // messages
    std::string why_not_;     // the last of them
    bool used_last_ = false;  // the last message was used
};

}  // namespace roomfix
