// The ROS 2 messages that we write: what they are called, and what is in them.
#pragma once

#include <cstdint>
#include <string>

namespace roomfix {

enum class RosType : std::uint8_t { pose_with_covariance_stamped, odometry, tf_message, diagnostic_array, camera_info, compressed_image };

/// "geometry_msgs/msg/PoseWithCovarianceStamped"
std::string ros_name_of(RosType type);
/// As ROS calls the type on DDS: "geometry_msgs::msg::dds_::PoseWithCovarianceStamped_"
std::string dds_name_of(RosType type);
/// The message's definition and those of all messages in it, as recordings carry them (encoding ros2msg).
std::string ros_definition_of(RosType type);

/// "/r1/pose" is "rt/r1/pose" on DDS.
std::string dds_topic_of(const std::string& ros_topic);

}  // namespace roomfix
