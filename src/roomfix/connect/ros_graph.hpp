// What ROS 2's own tools (`ros2 node list`, `ros2 topic info -v`) ask: which topics belong to which node. Every participant says it on `ros_discovery_info`.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "roomfix/connect/little_endian.hpp"

namespace roomfix::ros {

/// DDS's own number of a participant, a reader or a writer.
using Guid = std::array<std::uint8_t, 16>;

/// A participant with one node.
struct ParticipantEntitiesInfo {
    Guid participant = {};
    std::string node_namespace = "/", node_name;
    std::vector<Guid> readers, writers;
};

/// Two layouts of the message go by the same name: up to ROS 2 Humble a number has 24 bytes, since Iron 16. A node that gets the other one may crash.
enum class GraphLayout : std::uint8_t { numbers_of_16_bytes, numbers_of_24_bytes };

/// The layout in which a message of somebody else is whole; nothing where it is in neither.
std::optional<GraphLayout> layout_of_graph(std::span<const std::uint8_t> message);

Bytes encode(const ParticipantEntitiesInfo& message, GraphLayout layout);

inline const std::string graph_topic = "ros_discovery_info";  // on DDS
inline const std::string graph_type = "rmw_dds_common::msg::dds_::ParticipantEntitiesInfo_";

}  // namespace roomfix::ros
