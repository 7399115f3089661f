// ROS 2 topics over DDS, without ROS: what ROS 2's own nodes do on the network, by the same library.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "roomfix/base/result.hpp"
#include "roomfix/connect/little_endian.hpp"
#include "roomfix/connect/ros_type.hpp"

namespace roomfix {

/// The domain that ROS_DOMAIN_ID in the environment names, as ROS 2 takes it; 0 where it is not set. An error where it names none.
Result<int> domain_of_environment();

class DdsParticipant {
public:
    /// Joins a DDS domain (0..232, ROS_DOMAIN_ID of the others) as a node of that name. As ROS 2 does, it keeps to this machine where ROS_LOCALHOST_ONLY is 1
    /// in the environment. An error where the domain cannot be joined, or the program was built without DDS.
    static Result<std::unique_ptr<DdsParticipant>> join(int domain, const std::string& node);
    ~DdsParticipant();
    DdsParticipant(const DdsParticipant&) = delete;
    DdsParticipant& operator=(const DdsParticipant&) = delete;

    /// Offers a topic ("/r1/pose") with the quality of service that ROS 2 nodes have by default: reliable, volatile, the last `depth` messages kept.
    /// Who listens already gets the messages from then on.
    Result<void> offer(const std::string& topic, RosType type, int depth = 10);
    /// Nobody will publish on it any more.
    void withdraw(const std::string& topic);
    /// A message in CDR on an offered topic. From any thread, but not while its topic is withdrawn.
    Result<void> publish(const std::string& topic, const Bytes& message);
    /// Waits until all who listen have all messages, but not longer than so many seconds.
    void wait_until_received(double longest);

    /// Wants a topic from whoever publishes it, reliably or not: best effort, volatile, the last `depth` messages kept until they are taken.
    Result<void> want(const std::string& topic, RosType type, int depth = 100);
    /// Until a message has come on any wanted topic that was not taken yet, but not longer than so many seconds.
    void wait(double longest);
    /// The messages that have come on a wanted topic since the last call, in CDR.
    std::vector<Bytes> take(const std::string& topic);
    /// How many publish on a wanted topic, as far as is known here. One that was killed counts until it is missed: 20 s, or what it promised.
    int publishers(const std::string& topic) const;
    /// As what else somebody publishes on that topic ("std_msgs::msg::dds_::String_"); empty where nobody does.
    std::string other_type(const std::string& topic) const;

    /// Tells ROS 2's tools which topics are this node's; to be called about once a second. Nothing is told before somebody else's word shows in which of the
    /// two layouts they understand it (`ros_graph`).
    void tell_graph();

private:
    struct Impl;
    explicit DdsParticipant(std::unique_ptr<Impl> impl);

    std::unique_ptr<Impl> impl_;
};

}  // namespace roomfix
