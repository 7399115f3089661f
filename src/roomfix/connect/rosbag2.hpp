// What ROS 2 knows about recordings beside the messages in them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "roomfix/base/time.hpp"

namespace roomfix {

/// How a topic is offered, as rosbag2 writes it: reliable, volatile, the last `depth` messages kept.
std::string offered_qos_profiles(int depth = 10);

struct RecordedTopic {
    std::string name, type;
    std::uint64_t messages = 0;
};

struct BagContents {
    std::string file;  // name of the MCAP file in the bag's folder
    Nanoseconds start = 0, end = 0;
    std::vector<RecordedTopic> topics;
};

/// metadata.yaml of a bag's folder, in version 4, which every rosbag2 reads.
std::string bag_metadata(const BagContents& contents);

}  // namespace roomfix
