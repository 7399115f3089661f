// ROS 2 messages as plain values, and as the bytes that DDS and recordings carry (CDR).
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "roomfix/base/time.hpp"
#include "roomfix/connect/little_endian.hpp"

namespace roomfix::ros {

/// ROS counts whole seconds since 1970 in 31 bits.
constexpr bool can_state(Nanoseconds time) { return time >= 0 && time / 1'000'000'000 <= 0x7fffffff; }

struct Header {
    Nanoseconds stamp = 0;  // one that ROS can state
    std::string frame_id;
};

/// Row by row over x, y, z (m) and rotations about X, Y, Z (rad), fixed axes.
using Covariance = std::array<double, 36>;

struct Pose {
    Eigen::Vector3d position = Eigen::Vector3d::Zero();  // m
    Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
};

struct PoseWithCovarianceStamped {
    Header header;
    Pose pose;
    Covariance covariance = {};
};

struct Odometry {
    Header header;
    std::string child_frame_id;
    Pose pose;  // in the header's frame
    Covariance pose_covariance = {};
    Eigen::Vector3d linear = Eigen::Vector3d::Zero();   // m/s, in the child's frame
    Eigen::Vector3d angular = Eigen::Vector3d::Zero();  // rad/s
    Covariance twist_covariance = {};
};

struct TransformStamped {
    Header header;
    std::string child_frame_id;
    Pose transform;  // of the child's frame in the header's
};

struct TFMessage {
    std::vector<TransformStamped> transforms;
};

enum class Level : std::uint8_t { ok, warn, error, stale };

struct DiagnosticStatus {
    Level level = Level::ok;
    std::string name, message, hardware_id;
    std::vector<std::pair<std::string, std::string>> values;
};

struct DiagnosticArray {
    Header header;
    std::vector<DiagnosticStatus> status;
};

struct CameraInfo {
    Header header;
    std::uint32_t height = 0, width = 0;  // px
    std::string distortion_model;
    std::vector<double> d;
    std::array<double, 9> k = {};
    std::array<double, 9> r = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    std::array<double, 12> p = {};
};

struct CompressedImage {
    Header header;
    std::string format;  // "jpeg", "png"
    Bytes data;          // of the file
};

Bytes encode(const PoseWithCovarianceStamped& message);
Bytes encode(const Odometry& message);
Bytes encode(const TFMessage& message);
Bytes encode(const DiagnosticArray& message);
Bytes encode(const CameraInfo& message);
Bytes encode(const CompressedImage& message);

/// Of any bytes; its numbers may be any, NaN and infinite ones too. Nothing where they are no such message, or its time is one that ROS cannot state.
std::optional<Odometry> decode_odometry(std::span<const std::uint8_t> message);

}  // namespace roomfix::ros
