// A ROS 2 node without ROS, by another vendor's DDS than ours: prints what comes on a robot's topics, one JSON object per line, until its stdin is closed.
// ros2_listener DOMAIN ROBOT CAMERA
#include <dds/dds.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "ros_messages.h"

namespace {

constexpr int at_once = 64;  // messages

void die(const char* what, dds_return_t code) {
    std::fprintf(stderr, "ros2_listener: %s: %s\n", what, dds_strretcode(-code));
    std::exit(1);
}

/// What a ROS 2 subscriber asks for, but that it forgets nothing.
dds_entity_t subscribe(dds_entity_t participant, const dds_topic_descriptor_t& type, const std::string& name) {
    dds_qos_t* qos = dds_create_qos();
    dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
    dds_qset_durability(qos, DDS_DURABILITY_VOLATILE);
    dds_qset_history(qos, DDS_HISTORY_KEEP_ALL, DDS_LENGTH_UNLIMITED);
    const dds_entity_t topic = dds_create_topic(participant, &type, name.c_str(), nullptr, nullptr);
    if (topic < 0) die(name.c_str(), topic);
    const dds_entity_t reader = dds_create_reader(participant, topic, qos, nullptr);
    if (reader < 0) die(name.c_str(), reader);
    dds_delete_qos(qos);
    return reader;
}

/// Whatever has come, each message to `print`.
template <class Message, class Print>
void take(dds_entity_t reader, const Print& print) {
    void* messages[at_once] = {};
    dds_sample_info_t infos[at_once];
    for (dds_return_t count = 1; count > 0;) {
        count = dds_take(reader, messages, infos, at_once, at_once);
        if (count < 0) die("take", count);
        for (int i = 0; i < count; ++i) {
            if (infos[i].valid_data) print(*static_cast<const Message*>(messages[i]));
        }
        if (count > 0) dds_return_loan(reader, messages, count);
        messages[0] = nullptr;
    }
}

void print_stamp(const std_msgs_msg_dds__Header_& header) {
    std::printf("\"sec\": %d, \"nanosec\": %u, \"frame\": \"%s\"", header.stamp.sec, header.stamp.nanosec, header.frame_id);
}

template <class Point>
void print_place(const Point& p, const geometry_msgs_msg_dds__Quaternion_& q) {
    std::printf(", \"position\": [%.17g, %.17g, %.17g], \"quaternion\": [%.17g, %.17g, %.17g, %.17g]", p.x, p.y, p.z, q.x, q.y, q.z, q.w);
}

void print_pose(const geometry_msgs_msg_dds__PoseWithCovarianceStamped_& message) {
    std::printf("{\"pose\": {");
    print_stamp(message.header);
    print_place(message.pose.pose.position, message.pose.pose.orientation);
    std::printf(", \"covariance\": [");
    for (int i = 0; i < 36; ++i) std::printf("%s%.17g", i > 0 ? ", " : "", message.pose.covariance[i]);
    std::printf("]}}\n");
}

void print_numbers(const char* name, const double* values, uint32_t count) {
    std::printf(", \"%s\": [", name);
    for (uint32_t i = 0; i < count; ++i) std::printf("%s%.17g", i > 0 ? ", " : "", values[i]);
    std::printf("]");
}

void print_odometry(const nav_msgs_msg_dds__Odometry_& message) {
    std::printf("{\"odometry\": {");
    print_stamp(message.header);
    std::printf(", \"child\": \"%s\"", message.child_frame_id);
    print_place(message.pose.pose.position, message.pose.pose.orientation);
    const geometry_msgs_msg_dds__Vector3_ &linear = message.twist.twist.linear, &angular = message.twist.twist.angular;
    const double twist[] = {linear.x, linear.y, linear.z, angular.x, angular.y, angular.z};
    print_numbers("twist", twist, 6);
    print_numbers("covariance", message.pose.covariance, 36);
    print_numbers("twist_covariance", message.twist.covariance, 36);
    std::printf("}}\n");
}

void print_transforms(const tf2_msgs_msg_dds__TFMessage_& message) {
    for (uint32_t i = 0; i < message.transforms._length; ++i) {
        const geometry_msgs_msg_dds__TransformStamped_& t = message.transforms._buffer[i];
        std::printf("{\"transform\": {");
        print_stamp(t.header);
        std::printf(", \"child\": \"%s\"", t.child_frame_id);
        print_place(t.transform.translation, t.transform.rotation);
        std::printf("}}\n");
    }
}

void print_states(const diagnostic_msgs_msg_dds__DiagnosticArray_& message) {
    for (uint32_t i = 0; i < message.status._length; ++i) {
        const diagnostic_msgs_msg_dds__DiagnosticStatus_& s = message.status._buffer[i];
        std::printf("{\"state\": {");
        print_stamp(message.header);
        std::printf(", \"level\": %d, \"name\": \"%s\", \"message\": \"%s\", \"id\": \"%s\", \"values\": {", s.level, s.name, s.message, s.hardware_id);
        for (uint32_t k = 0; k < s.values._length; ++k) {
            std::printf("%s\"%s\": \"%s\"", k > 0 ? ", " : "", s.values._buffer[k].key, s.values._buffer[k].value);
        }
        std::printf("}}}\n");
    }
}

void print_camera(const sensor_msgs_msg_dds__CameraInfo_& message) {
    std::printf("{\"camera\": {");
    print_stamp(message.header);
    std::printf(", \"size\": [%u, %u], \"model\": \"%s\", \"rectify\": %d", message.width, message.height, message.distortion_model, message.roi.do_rectify);
    print_numbers("d", message.d._buffer, message.d._length);
    print_numbers("k", message.k, 9);
    print_numbers("r", message.r, 9);
    print_numbers("p", message.p, 12);
    std::printf("}}\n");
}

void print_guid(const uint8_t* guid) {
    std::printf("\"");
    for (int i = 0; i < 16; ++i) std::printf("%02x", static_cast<unsigned>(guid[i]));
    std::printf("\"");
}

/// Which topics belong to which node, as `ros2 node list` and `ros2 topic info` would show it.
void print_graph(const rmw_dds_common_msg_dds__ParticipantEntitiesInfo_& message) {
    for (uint32_t i = 0; i < message.node_entities_info_seq._length; ++i) {
        const rmw_dds_common_msg_dds__NodeEntitiesInfo_& node = message.node_entities_info_seq._buffer[i];
        std::printf("{\"node\": {\"name\": \"%s%s\", \"readers\": %u, \"participant\": ", node.node_namespace, node.node_name, node.reader_gid_seq._length);
        print_guid(message.gid.data);
        std::printf(", \"writers\": [");
        for (uint32_t k = 0; k < node.writer_gid_seq._length; ++k) {
            std::printf("%s", k > 0 ? ", " : "");
            print_guid(node.writer_gid_seq._buffer[k].data);
        }
        std::printf("]}}\n");
    }
}

/// Tells of itself as a node does, so that others see which ROS it is of. Gives the reader of what they tell.
dds_entity_t join_graph(dds_entity_t participant) {
    dds_qos_t* qos = dds_create_qos();
    dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
    dds_qset_durability(qos, DDS_DURABILITY_TRANSIENT_LOCAL);
    dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 100);
    const dds_entity_t topic = dds_create_topic(participant, &rmw_dds_common_msg_dds__ParticipantEntitiesInfo__desc, "ros_discovery_info", nullptr, nullptr);
    const dds_entity_t reader = dds_create_reader(participant, topic, qos, nullptr);
    dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 1);
    const dds_entity_t writer = dds_create_writer(participant, topic, qos, nullptr);
    if (topic < 0 || reader < 0 || writer < 0) die("ros_discovery_info", writer);
    dds_delete_qos(qos);
    char space[] = "/", name[] = "listener";
    rmw_dds_common_msg_dds__NodeEntitiesInfo_ node = {};
    node.node_namespace = space;
    node.node_name = name;
    rmw_dds_common_msg_dds__ParticipantEntitiesInfo_ info = {};
    dds_guid_t guid;
    if (dds_get_guid(participant, &guid) == DDS_RETCODE_OK) std::copy(guid.v, guid.v + sizeof guid.v, info.gid.data);
    info.node_entities_info_seq._maximum = info.node_entities_info_seq._length = 1;
    info.node_entities_info_seq._buffer = &node;
    if (const dds_return_t told = dds_write(writer, &info); told != DDS_RETCODE_OK) die("ros_discovery_info", told);
    return reader;
}

/// By DDS's own numbers, who publishes what a reader gets.
void print_publications(dds_entity_t reader) {
    dds_instance_handle_t handles[at_once];
    const dds_return_t count = dds_get_matched_publications(reader, handles, at_once);
    for (dds_return_t i = 0; i < count && i < at_once; ++i) {
        dds_builtintopic_endpoint_t* endpoint = dds_get_matched_publication_data(reader, handles[i]);
        if (endpoint == nullptr) continue;
        std::printf("{\"publication\": {\"topic\": \"%s\", \"type\": \"%s\", \"writer\": ", endpoint->topic_name, endpoint->type_name);
        print_guid(endpoint->key.v);
        std::printf("}}\n");
        dds_builtintopic_free_endpoint(endpoint);
    }
}

bool stdin_is_closed() {
    pollfd input{STDIN_FILENO, POLLIN, 0};
    char ignored;
    return poll(&input, 1, 0) > 0 && read(STDIN_FILENO, &ignored, 1) <= 0;
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 4) {
        std::fprintf(stderr, "ros2_listener DOMAIN ROBOT CAMERA\n");
        return 2;
    }
    const dds_entity_t participant = dds_create_participant(static_cast<dds_domainid_t>(std::atoi(argv[1])), nullptr, nullptr);
    if (participant < 0) die("participant", participant);
    const dds_entity_t poses = subscribe(participant, geometry_msgs_msg_dds__PoseWithCovarianceStamped__desc, std::string("rt/") + argv[2] + "/pose");
    const dds_entity_t odometry = subscribe(participant, nav_msgs_msg_dds__Odometry__desc, std::string("rt/") + argv[2] + "/odometry");
    const dds_entity_t transforms = subscribe(participant, tf2_msgs_msg_dds__TFMessage__desc, "rt/tf");
    const dds_entity_t states = subscribe(participant, diagnostic_msgs_msg_dds__DiagnosticArray__desc, "rt/diagnostics");
    const dds_entity_t cameras = subscribe(participant, sensor_msgs_msg_dds__CameraInfo__desc, std::string("rt/") + argv[3] + "/camera_info");
    const dds_entity_t graph = join_graph(participant);
    const dds_entity_t waiting = dds_create_waitset(participant);
    for (const dds_entity_t reader : {poses, odometry, transforms, states, cameras, graph}) {
        dds_set_status_mask(reader, DDS_DATA_AVAILABLE_STATUS);
        dds_waitset_attach(waiting, reader, reader);
    }
    std::printf("{\"listening\": true}\n");
    std::fflush(stdout);
    for (bool last = false; !last;) {
        last = stdin_is_closed();  // what has come until then is still printed
        if (last) print_publications(odometry);
        dds_waitset_wait(waiting, nullptr, 0, DDS_MSECS(100));
        take<geometry_msgs_msg_dds__PoseWithCovarianceStamped_>(poses, print_pose);
        take<nav_msgs_msg_dds__Odometry_>(odometry, print_odometry);
        take<rmw_dds_common_msg_dds__ParticipantEntitiesInfo_>(graph, print_graph);
        take<tf2_msgs_msg_dds__TFMessage_>(transforms, print_transforms);
        take<diagnostic_msgs_msg_dds__DiagnosticArray_>(states, print_states);
        take<sensor_msgs_msg_dds__CameraInfo_>(cameras, print_camera);
        std::fflush(stdout);
    }
    dds_delete(participant);
    return 0;
}
