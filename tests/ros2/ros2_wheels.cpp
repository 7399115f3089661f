// A robot's node without ROS, by another vendor's DDS than ours: publishes nav_msgs/msg/Odometry for each line `SECONDS NANOSECONDS X Y YAW` of its stdin.
// ros2_wheels DOMAIN TOPIC reliable|best_effort
#include <dds/dds.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "ros_messages.h"

namespace {

void die(const char* what, dds_return_t code) {
    std::fprintf(stderr, "ros2_wheels: %s: %s\n", what, dds_strretcode(-code));
    std::exit(1);
}

dds_entity_t publish(dds_entity_t participant, const std::string& name, bool reliable) {
    dds_qos_t* qos = dds_create_qos();
    dds_qset_reliability(qos, reliable ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT, DDS_SECS(1));
    dds_qset_durability(qos, DDS_DURABILITY_VOLATILE);
    dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 10);
    const dds_entity_t topic = dds_create_topic(participant, &nav_msgs_msg_dds__Odometry__desc, name.c_str(), nullptr, nullptr);
    if (topic < 0) die(name.c_str(), topic);
    const dds_entity_t writer = dds_create_writer(participant, topic, qos, nullptr);
    if (writer < 0) die(name.c_str(), writer);
    dds_delete_qos(qos);
    return writer;
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 4) {
        std::fprintf(stderr, "ros2_wheels DOMAIN TOPIC reliable|best_effort\n");
        return 2;
    }
    const dds_entity_t participant = dds_create_participant(static_cast<dds_domainid_t>(std::atoi(argv[1])), nullptr, nullptr);
    if (participant < 0) die("participant", participant);
    const dds_entity_t writer = publish(participant, std::string("rt") + argv[2], std::string(argv[3]) == "reliable");
    char frame[] = "odom", child[] = "base_link";
    nav_msgs_msg_dds__Odometry_ message = {};
    message.header.frame_id = frame;
    message.child_frame_id = child;
    for (int i = 0; i < 36; i += 7) message.pose.covariance[i] = message.twist.covariance[i] = 0.01;
    double yaw = 0;
    while (std::scanf("%d %u %lf %lf %lf", &message.header.stamp.sec, &message.header.stamp.nanosec, &message.pose.pose.position.x,
                      &message.pose.pose.position.y, &yaw) == 5) {
        message.pose.pose.orientation.z = std::sin(0.5 * yaw);
        message.pose.pose.orientation.w = std::cos(0.5 * yaw);
        if (const dds_return_t written = dds_write(writer, &message); written != DDS_RETCODE_OK) die("write", written);
    }
    dds_delete(participant);
    return 0;
}
