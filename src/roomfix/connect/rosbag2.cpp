#include "roomfix/connect/rosbag2.hpp"

#include <fmt/format.h>

namespace roomfix {
namespace {

constexpr const char* forever = "  {}:\n    sec: 9223372036\n    nsec: 854775807\n";

/// A text of several lines in double quotes.
std::string quoted(const std::string& text) {
    std::string quoted = "\"";
    for (const char c : text) {
        if (c == '\n') {
            quoted += "\\n";
        } else {
            if (c == '"' || c == '\\') quoted += '\\';
            quoted += c;
        }
    }
    return quoted + "\"";
}

}  // namespace

std::string offered_qos_profiles(int depth) {
    constexpr int keep_last = 1, reliable = 1, of_now = 2, automatic = 1;
    return fmt::format("- history: {}\n  depth: {}\n  reliability: {}\n  durability: {}\n", keep_last, depth, reliable, of_now) +
           fmt::format(forever, "deadline") + fmt::format(forever, "lifespan") + fmt::format("  liveliness: {}\n", automatic) +
           fmt::format(forever, "liveliness_lease_duration") + "  avoid_ros_namespace_conventions: false";
}

std::string bag_metadata(const BagContents& contents) {
    std::uint64_t messages = 0;
    std::string topics;
    for (const RecordedTopic& topic : contents.topics) {
        messages += topic.messages;
        topics += fmt::format(
            "    - topic_metadata:\n        name: {}\n        type: {}\n        serialization_format: cdr\n        offered_qos_profiles: {}\n"
            "      message_count: {}\n",
            topic.name, topic.type, quoted(offered_qos_profiles()), topic.messages);
    }
    return fmt::format(
        "rosbag2_bagfile_information:\n  version: 4\n  storage_identifier: mcap\n  relative_file_paths:\n    - {}\n  duration:\n    nanoseconds: {}\n"
        "  starting_time:\n    nanoseconds_since_epoch: {}\n  message_count: {}\n  topics_with_message_count:{}\n{}  compression_format: \"\"\n"
        "  compression_mode: \"\"\n",
        quoted(contents.file), contents.end - contents.start, contents.start, messages, topics.empty() ? " []" : "", topics);
}

}  // namespace roomfix
