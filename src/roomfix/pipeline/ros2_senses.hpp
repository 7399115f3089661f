// Wheels that are reported on ROS 2 topics: `odometry: {source: 'ros2:/r1/odom'}`.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "roomfix/connect/dds_participant.hpp"
#include "roomfix/connect/ros_odometry.hpp"
#include "roomfix/site/site.hpp"

namespace roomfix {

bool is_ros_topic(const std::string& source);

/// All such topics of a site, as one node.
class Ros2Senses {
public:
    /// Listens in the domain of the site's output, or where it has none in that of ROS_DOMAIN_ID, or in 0. An error where the domain cannot be joined.
    static Result<std::unique_ptr<Ros2Senses>> open(const Site& site);

    /// What has come from one source since the last time.
    struct Heard {
        std::string source;  // as the site file names it
        OdometryBatch reports;
        std::string told;  // how it fares at present: who is missing, or how the sender's clock differs
    };
    /// Of every source, also of silent ones. Waits for the first message, but not longer than so many seconds.
    std::vector<Heard> read(double longest);

private:
    struct Topic {
        std::string source, name;
        RosOdometry odometry;
        double last_came = -1;  // s, steady; -1: never
    };
    Ros2Senses(std::unique_ptr<DdsParticipant> participant, int domain) : participant_(std::move(participant)), domain_(domain) {}
    OdometryBatch read(Topic& topic);
    std::string told(const Topic& topic) const;
    void tell_graph();

    std::unique_ptr<DdsParticipant> participant_;
    int domain_;
    std::vector<Topic> topics_;
    double last_graph_ = -1;  // s, steady; -1: never
};

}  // namespace roomfix
