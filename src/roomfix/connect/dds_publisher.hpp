// ROS 2 topics over DDS, without ROS: what ROS 2's own nodes do on the network, by the same library.
#pragma once

#include <memory>
#include <string>

#include "roomfix/base/result.hpp"
#include "roomfix/connect/little_endian.hpp"
#include "roomfix/connect/ros_type.hpp"

namespace roomfix {

class DdsPublisher {
public:
    /// Joins a DDS domain (0..232, ROS_DOMAIN_ID of the nodes that listen). As ROS 2 does, it keeps to this machine where ROS_LOCALHOST_ONLY is 1 in the
    /// environment. An error where the domain cannot be joined, or the program was built without DDS.
    static Result<std::unique_ptr<DdsPublisher>> join(int domain);
    ~DdsPublisher();
    DdsPublisher(const DdsPublisher&) = delete;
    DdsPublisher& operator=(const DdsPublisher&) = delete;

    /// Offers a topic ("/r1/pose") with the quality of service that ROS 2 nodes have by default: reliable, volatile, the last `depth` messages kept.
    /// Who listens already gets the messages from then on.
    Result<void> offer(const std::string& topic, RosType type, int depth = 10);
    /// Nobody will publish on it any more.
    void withdraw(const std::string& topic);
    /// A message in CDR on an offered topic. From any thread, but not while its topic is withdrawn.
    Result<void> publish(const std::string& topic, const Bytes& message);
    /// Waits until all who listen have all messages, but not longer than so many seconds.
    void wait_until_received(double longest);

private:
    struct Impl;
    explicit DdsPublisher(std::unique_ptr<Impl> impl);

    std::unique_ptr<Impl> impl_;
};

}  // namespace roomfix
