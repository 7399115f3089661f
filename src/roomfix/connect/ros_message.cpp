#include "roomfix/connect/ros_message.hpp"

#include "roomfix/connect/cdr_reader.hpp"
#include "roomfix/connect/cdr_writer.hpp"

namespace roomfix::ros {
namespace {

constexpr Nanoseconds second = 1'000'000'000;

void put(CdrWriter& cdr, const Header& header) {
    cdr.put(static_cast<std::int32_t>(header.stamp / second));
    cdr.put(static_cast<std::uint32_t>(header.stamp % second));
    cdr.put(header.frame_id);
}

void put(CdrWriter& cdr, const Eigen::Vector3d& vector) {
    for (const double value : vector) cdr.put(value);
}

void put(CdrWriter& cdr, const Pose& pose) {
    put(cdr, pose.position);
    const Eigen::Quaterniond& q = pose.orientation;
    for (const double value : {q.x(), q.y(), q.z(), q.w()}) cdr.put(value);
}

void put(CdrWriter& cdr, const DiagnosticStatus& status) {
    cdr.put(static_cast<std::uint8_t>(status.level));
    cdr.put(status.name);
    cdr.put(status.message);
    cdr.put(status.hardware_id);
    cdr.put_count(status.values.size());
    for (const auto& [key, value] : status.values) {
        cdr.put(key);
        cdr.put(value);
    }
}

Eigen::Vector3d get_vector(CdrReader& cdr) {
    Eigen::Vector3d vector;
    for (double& value : vector) value = cdr.get<double>();
    return vector;
}

Eigen::Quaterniond get_quaternion(CdrReader& cdr) {
    Eigen::Quaterniond q;
    for (double* value : {&q.x(), &q.y(), &q.z(), &q.w()}) *value = cdr.get<double>();
    return q;
}

}  // namespace

Bytes encode(const PoseWithCovarianceStamped& message) {
    CdrWriter cdr;
    put(cdr, message.header);
    put(cdr, message.pose);
    cdr.put_array(message.covariance);
    return cdr.take();
}

Bytes encode(const Odometry& message) {
    CdrWriter cdr;
    put(cdr, message.header);
    cdr.put(message.child_frame_id);
    put(cdr, message.pose);
    cdr.put_array(message.pose_covariance);
    put(cdr, message.linear);
    put(cdr, message.angular);
    cdr.put_array(message.twist_covariance);
    return cdr.take();
}

Bytes encode(const TFMessage& message) {
    CdrWriter cdr;
    cdr.put_count(message.transforms.size());
    for (const TransformStamped& transform : message.transforms) {
        put(cdr, transform.header);
        cdr.put(transform.child_frame_id);
        put(cdr, transform.transform);
    }
    return cdr.take();
}

Bytes encode(const DiagnosticArray& message) {
    CdrWriter cdr;
    put(cdr, message.header);
    cdr.put_count(message.status.size());
    for (const DiagnosticStatus& status : message.status) put(cdr, status);
    return cdr.take();
}

Bytes encode(const CameraInfo& message) {
    CdrWriter cdr;
    put(cdr, message.header);
    cdr.put(message.height);
    cdr.put(message.width);
    cdr.put(message.distortion_model);
    cdr.put_count(message.d.size());
    cdr.put_array(message.d);
    cdr.put_array(message.k);
    cdr.put_array(message.r);
    cdr.put_array(message.p);
    constexpr std::uint32_t not_stated = 0;
    for (int i = 0; i < 6; ++i) cdr.put(not_stated);  // binning in x and y; region of interest: offsets, height, width
    cdr.put(false);                                   // the region is not to be rectified
    return cdr.take();
}

Bytes encode(const CompressedImage& message) {
    CdrWriter cdr;
    put(cdr, message.header);
    cdr.put(message.format);
    cdr.put_bytes(message.data);
    return cdr.take();
}

std::optional<Odometry> decode_odometry(std::span<const std::uint8_t> message) {
    CdrReader cdr(message);
    Odometry odometry;
    const auto seconds = cdr.get<std::int32_t>();
    const auto nanoseconds = cdr.get<std::uint32_t>();
    odometry.header = {second * seconds + nanoseconds, cdr.text()};
    odometry.child_frame_id = cdr.text();
    odometry.pose.position = get_vector(cdr);
    odometry.pose.orientation = get_quaternion(cdr);
    cdr.get(odometry.pose_covariance);
    odometry.linear = get_vector(cdr);
    odometry.angular = get_vector(cdr);
    cdr.get(odometry.twist_covariance);
    if (!cdr.good() || nanoseconds >= second || !can_state(odometry.header.stamp)) return std::nullopt;
    return odometry;
}

}  // namespace roomfix::ros
