#include "roomfix/connect/ros_type.hpp"

#include <algorithm>
#include <string_view>
#include <vector>

namespace roomfix {
namespace {

/// A message and those that it is made of.
struct Definition {
    std::string_view package, name, fields;
    std::vector<std::string_view> parts;  // by name
};

const std::vector<Definition>& definitions() {
    static const std::vector<Definition> all = {
        {"builtin_interfaces", "Time", "int32 sec\nuint32 nanosec\n", {}},
        {"std_msgs", "Header", "builtin_interfaces/Time stamp\nstring frame_id\n", {"Time"}},
        {"geometry_msgs", "Point", "float64 x\nfloat64 y\nfloat64 z\n", {}},
        {"geometry_msgs", "Vector3", "float64 x\nfloat64 y\nfloat64 z\n", {}},
        {"geometry_msgs", "Quaternion", "float64 x\nfloat64 y\nfloat64 z\nfloat64 w\n", {}},
        {"geometry_msgs", "Pose", "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n", {"Point", "Quaternion"}},
        {"geometry_msgs", "Twist", "geometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular\n", {"Vector3"}},
        {"geometry_msgs", "Transform", "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n", {"Vector3", "Quaternion"}},
        {"geometry_msgs", "PoseWithCovariance", "geometry_msgs/Pose pose\nfloat64[36] covariance\n", {"Pose"}},
        {"geometry_msgs", "TwistWithCovariance", "geometry_msgs/Twist twist\nfloat64[36] covariance\n", {"Twist"}},
        {"geometry_msgs", "PoseWithCovarianceStamped", "std_msgs/Header header\ngeometry_msgs/PoseWithCovariance pose\n", {"Header", "PoseWithCovariance"}},
        {"geometry_msgs", "TransformStamped", "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform\n", {"Header", "Transform"}},
        {"nav_msgs",
         "Odometry",
         "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/PoseWithCovariance pose\ngeometry_msgs/TwistWithCovariance twist\n",
         {"Header", "PoseWithCovariance", "TwistWithCovariance"}},
        {"tf2_msgs", "TFMessage", "geometry_msgs/TransformStamped[] transforms\n", {"TransformStamped"}},
        {"diagnostic_msgs", "KeyValue", "string key\nstring value\n", {}},
        {"diagnostic_msgs",
         "DiagnosticStatus",
         "byte OK=0\nbyte WARN=1\nbyte ERROR=2\nbyte STALE=3\nbyte level\nstring name\nstring message\nstring hardware_id\n"
         "diagnostic_msgs/KeyValue[] values\n",
         {"KeyValue"}},
        {"diagnostic_msgs", "DiagnosticArray", "std_msgs/Header header\ndiagnostic_msgs/DiagnosticStatus[] status\n", {"Header", "DiagnosticStatus"}},
        {"sensor_msgs", "RegionOfInterest", "uint32 x_offset\nuint32 y_offset\nuint32 height\nuint32 width\nbool do_rectify\n", {}},
        {"sensor_msgs",
         "CameraInfo",
         "std_msgs/Header header\nuint32 height\nuint32 width\nstring distortion_model\nfloat64[] d\nfloat64[9] k\nfloat64[9] r\nfloat64[12] p\n"
         "uint32 binning_x\nuint32 binning_y\nsensor_msgs/RegionOfInterest roi\n",
         {"Header", "RegionOfInterest"}},
        {"sensor_msgs", "CompressedImage", "std_msgs/Header header\nstring format\nuint8[] data\n", {"Header"}},
    };
    return all;
}

const Definition& definition_named(std::string_view name) {
    return *std::find_if(definitions().begin(), definitions().end(), [&](const Definition& d) { return d.name == name; });
}

const Definition& definition_of(RosType type) {
    switch (type) {
        case RosType::pose_with_covariance_stamped:
            return definition_named("PoseWithCovarianceStamped");
        case RosType::odometry:
            return definition_named("Odometry");
        case RosType::tf_message:
            return definition_named("TFMessage");
        case RosType::diagnostic_array:
            return definition_named("DiagnosticArray");
        case RosType::camera_info:
            return definition_named("CameraInfo");
        case RosType::compressed_image:
            break;
    }
    return definition_named("CompressedImage");
}

std::string joined(std::string_view a, std::string_view between, std::string_view b) { return std::string(a).append(between).append(b); }

/// Appends the parts of a message that are not there yet, each with all of its own.
void add_parts(const Definition& whole, std::vector<const Definition*>& all) {
    for (const std::string_view name : whole.parts) {
        const Definition& part = definition_named(name);
        if (std::find(all.begin(), all.end(), &part) != all.end()) continue;
        all.push_back(&part);
        add_parts(part, all);
    }
}

}  // namespace

std::string ros_name_of(RosType type) { return joined(definition_of(type).package, "/msg/", definition_of(type).name); }

std::string dds_name_of(RosType type) { return joined(definition_of(type).package, "::msg::dds_::", definition_of(type).name) + "_"; }

std::string ros_definition_of(RosType type) {
    const Definition& whole = definition_of(type);
    std::vector<const Definition*> parts;
    add_parts(whole, parts);
    std::string text(whole.fields);
    for (const Definition* part : parts) {
        text += std::string(80, '=') + "\nMSG: " + joined(part->package, "/", part->name) + "\n";
        text += part->fields;
    }
    return text;
}

std::string dds_topic_of(const std::string& ros_topic) { return "rt" + ros_topic; }

}  // namespace roomfix
