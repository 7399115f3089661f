#include "roomfix/pipeline/ros2_senses.hpp"

#include <fmt/format.h>

#include <utility>

#include "roomfix/base/steady_now.hpp"

namespace roomfix {
namespace {

constexpr std::string_view scheme = "ros2:";
constexpr double silent_after = 2;  // s: wheels report many times a second

Result<int> domain_of(const Site& site) {
    if (site.outputs.ros2) return site.outputs.ros2->domain;
    return domain_of_environment();
}

}  // namespace

bool is_ros_topic(const std::string& source) { return source.starts_with(scheme); }

Result<std::unique_ptr<Ros2Senses>> Ros2Senses::open(const Site& site) {
    const auto domain = domain_of(site);
    if (!domain) return Error{domain.error().message};
    auto participant = DdsParticipant::join(*domain, "roomfix_senses");
    if (!participant) return participant.error();
    std::unique_ptr<Ros2Senses> senses(new Ros2Senses(std::move(*participant), *domain));
    for (std::size_t r = 0; r < site.robots.size(); ++r) {
        const auto& odometry = site.robots[r].odometry;
        if (!odometry || !is_ros_topic(odometry->source)) continue;
        const std::string topic = odometry->source.substr(scheme.size());
        if (auto wanted = senses->participant_->want(topic, RosType::odometry); !wanted) return wanted.error();
        senses->topics_.push_back({odometry->source, topic, RosOdometry(static_cast<int>(r))});
    }
    return senses;
}

std::vector<Ros2Senses::Heard> Ros2Senses::read(double longest) {
    participant_->wait(longest);
    std::vector<Heard> heard;
    for (Topic& topic : topics_) {
        OdometryBatch reports = read(topic);
        heard.push_back({topic.source, std::move(reports), told(topic)});
    }
    tell_graph();
    return heard;
}

OdometryBatch Ros2Senses::read(Topic& topic) {
    OdometryBatch all;
    for (const Bytes& message : participant_->take(topic.name)) {
        const OdometryBatch one = topic.odometry.read(message, system_now(), steady_now());
        all.poses.insert(all.poses.end(), one.poses.begin(), one.poses.end());
        for (const std::string& problem : one.problems) all.problems.push_back(fmt::format("{}: a message was not used, since {}", topic.source, problem));
        topic.last_came = steady_now();
    }
    return all;
}

void Ros2Senses::tell_graph() {
    constexpr double interval = 1;  // s
    if (last_graph_ >= 0 && steady_now() - last_graph_ < interval) return;
    participant_->tell_graph();
    last_graph_ = steady_now();
}

std::string Ros2Senses::told(const Topic& topic) const {
    const double silent = steady_now() - topic.last_came;
    if (topic.last_came >= 0 && silent < silent_after) return topic.odometry.told();
    const int publishers = participant_->publishers(topic.name);
    if (topic.last_came >= 0) {
        return fmt::format("silent for {:.0f} s{}", silent, publishers == 0 ? ": who published it is gone" : ", though who publishes it has not left");
    }
    if (publishers > 0) return "somebody publishes it, but nothing has come yet";
    if (const std::string other = participant_->other_type(topic.name); !other.empty()) {
        return fmt::format("in domain {} {} is published as {}, not as nav_msgs/msg/Odometry", domain_, topic.name, other);
    }
    return fmt::format(
        "nobody publishes nav_msgs/msg/Odometry on {} in domain {}: does the robot's node run, with this ROS_DOMAIN_ID, and does the network pass multicast?",
        topic.name, domain_);
}

}  // namespace roomfix
