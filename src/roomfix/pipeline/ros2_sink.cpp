#include "roomfix/pipeline/ros2_sink.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <utility>
#include <vector>

#include "roomfix/connect/fix_json.hpp"
#include "roomfix/connect/ros_fix.hpp"

namespace roomfix {
namespace {

const std::string transform_topic = "/tf";
const std::string state_topic = "/diagnostics";

std::string pose_topic(const std::string& word) { return "/" + word + "/pose"; }
std::string odometry_topic(const std::string& word) { return "/" + word + "/odometry"; }

/// Keeps the first error, which is the one that is told.
void note(Result<void>& first, const Result<void>& result) {
    if (first && !result) first = result;
}

ros::Level level_of(const std::string& camera_status) {
    if (camera_status == "ok") return ros::Level::ok;
    if (camera_status == "ended") return ros::Level::stale;
    return camera_status == "waiting" || camera_status == "slow" || camera_status == "changed" || camera_status == "moved" ? ros::Level::warn
                                                                                                                           : ros::Level::error;
}

ros::Level level_of(FixStatus status) {
    if (status == FixStatus::ok) return ros::Level::ok;
    return status == FixStatus::coasting ? ros::Level::warn : ros::Level::error;
}

ros::DiagnosticStatus status_of(const CameraState& state) {
    return {level_of(state.status),
            "roomfix: camera " + state.id,
            state.message.empty() ? state.status : state.message,
            state.id,
            {{"status", state.status},
             {"frames", fmt::format("{}", state.frames)},
             {"bad frames", fmt::format("{}", state.bad_frames)},
             {"dropped frames", fmt::format("{}", state.dropped)},
             {"rate (Hz)", fmt::format("{:.2f}", state.rate)},
             {"time per frame (s)", fmt::format("{:.4f}", state.busy)}}};
}

ros::DiagnosticStatus status_of(const Fix& fix, bool without_odometry) {
    ros::DiagnosticStatus status{level_of(fix.status), "roomfix: robot " + fix.robot, fix.reason, fix.robot, {{"status", name_of(fix.status)}}};
    if (fix.status == FixStatus::coasting) status.message = "predicted only: no camera and no sense finds it at present";
    if (!without_odometry) return status;
    status.level = std::max(status.level, ros::Level::warn);
    status.message += (status.message.empty() ? "" : "; ") + std::string("no report of its wheels beside its fixes: map -> odom is not told");
    return status;
}

}  // namespace

Result<std::unique_ptr<Ros2Sink>> Ros2Sink::open(const SiteTracker& tracker, const Ros2Output& settings) {
    auto participant = DdsParticipant::join(settings.domain, "roomfix");
    if (!participant) return participant.error();
    std::unique_ptr<Ros2Sink> sink(new Ros2Sink(tracker, settings, std::move(*participant)));
    if (auto offered = sink->offer_topics(); !offered) return offered.error();
    sink->states_ = std::thread([raw = sink.get()] { raw->tell_states(); });
    return sink;
}

Ros2Sink::Ros2Sink(const SiteTracker& tracker, const Ros2Output& settings, std::unique_ptr<DdsParticipant> participant)
    : tracker_(tracker), settings_(settings), participant_(std::move(participant)) {}

Ros2Sink::~Ros2Sink() { stop(); }

std::string Ros2Sink::name() const { return fmt::format("ROS 2 in domain {}", settings_.domain); }

/// Early: whoever wants a topic needs a moment to find it.
Result<void> Ros2Sink::offer_topics() {
    constexpr int transforms_kept = 100;
    Result<void> offered = participant_->offer(transform_topic, RosType::tf_message, transforms_kept);
    note(offered, participant_->offer(state_topic, RosType::diagnostic_array));
    for (const SiteRobot& robot : tracker_.site().robots) {
        if (!robot.many) note(offered, offer_fixes(robot.id));
    }
    for (std::size_t i = 0; i < tracker_.cameras(); ++i) {
        note(offered, participant_->offer("/" + camera_names_.of(tracker_.camera(i).id) + "/camera_info", RosType::camera_info));
    }
    return offered;
}

Result<void> Ros2Sink::offer_fixes(const std::string& robot) {
    const std::string& word = names_.of(robot);
    Result<void> offered = participant_->offer(pose_topic(word), RosType::pose_with_covariance_stamped);
    note(offered, participant_->offer(odometry_topic(word), RosType::odometry));
    return offered;
}

bool Ros2Sink::has_odometry(const std::string& robot) const {
    const auto index = tracker_.site().robot(robot);
    return index && tracker_.site().robots[static_cast<std::size_t>(*index)].odometry;
}

RobotFrames Ros2Sink::frames(const std::string& robot) {
    const std::vector<SiteRobot>& robots = tracker_.site().robots;
    return robot_frames(names_.of(robot), robots.size() == 1 && !robots[0].many);
}

Result<void> Ros2Sink::give(const FixBatch& batch) {
    Result<void> given;
    for (const Fix& fix : batch.given) {
        if (!fix.robot.empty() && !fix.unknown && ros::has_pose(fix) && ros::can_state(fix.time)) note(given, give_fix(fix));
    }
    note(given, give_transforms(batch));
    note_states(batch);
    forget_gone(batch);
    return given;
}

/// Its pose, and where it has a velocity in its own axes both together.
Result<void> Ros2Sink::give_fix(const Fix& fix) {
    if (!tracker_.site().robot(fix.robot) && !passing_.contains(fix.robot)) {
        if (auto offered = offer_fixes(fix.robot); !offered) return offered;
        passing_.insert(fix.robot);
    }
    const std::string& word = names_.of(fix.robot);
    Result<void> given = participant_->publish(pose_topic(word), ros::encode(ros::pose_message(fix)));
    if (ros::has_twist(fix)) note(given, participant_->publish(odometry_topic(word), ros::encode(ros::odometry_message(fix, frames(fix.robot).base))));
    return given;
}

/// Of many robots that are alike each new one gets a new name: topics of those that are gone would add up.
void Ros2Sink::forget_gone(const FixBatch& batch) {
    std::erase_if(passing_, [&](const std::string& robot) {
        if (std::any_of(batch.all.begin(), batch.all.end(), [&](const Fix& fix) { return fix.robot == robot; })) return false;
        participant_->withdraw(pose_topic(names_.of(robot)));
        participant_->withdraw(odometry_topic(names_.of(robot)));
        names_.forget(robot);
        last_transform_.erase(robot);
        return true;
    });
}

/// REP 105: of a robot with odometry `map -> odom`, since `odom -> base_link` is the robot's own; never both.
Result<void> Ros2Sink::give_transforms(const FixBatch& batch) {
    for (const OdometryObservation& report : batch.odometry) {
        corrections_[tracker_.site().robots[static_cast<std::size_t>(report.robot)].id].add_report(report);
    }
    ros::TFMessage message;
    for (const Fix& fix : batch.given) {
        if (fix.robot.empty() || fix.unknown || !fix.yaw_known || !ros::has_pose(fix) || !ros::can_state(fix.time)) continue;
        if (has_odometry(fix.robot)) {
            corrections_[fix.robot].add_fix(fix.time, fix.pose);
        } else if (const auto [last, first] = last_transform_.try_emplace(fix.robot, fix.time);
                   settings_.robot_transform && (first || fix.time > last->second)) {
            last->second = fix.time;
            message.transforms.push_back(ros::transform_message(fix.time, map_frame, names_.of(fix.robot) + "/base_link", fix.pose));
        }
    }
    for (auto& [robot, corrections] : corrections_) {
        for (const auto& [time, map_from_odom] : corrections.take(batch.time)) {
            message.transforms.push_back(ros::transform_message(time, map_frame, frames(robot).odom, map_from_odom));
        }
    }
    return message.transforms.empty() ? Result<void>() : participant_->publish(transform_topic, ros::encode(message));
}

void Ros2Sink::note_states(const FixBatch& batch) {
    const std::lock_guard lock(mutex_);
    robots_.clear();
    for (const Fix& fix : batch.all) {
        if (fix.robot.empty() || fix.unknown) continue;
        const auto corrections = corrections_.find(fix.robot);
        robots_[fix.robot] = status_of(fix, corrections != corrections_.end() && corrections->second.missing_reports());
    }
}

/// Once a second, also while nothing else comes: that is when it matters. And how all was in the end.
void Ros2Sink::tell_states() {
    std::unique_lock lock(mutex_);
    for (bool last = false; !last;) {
        last = changed_.wait_for(lock, std::chrono::seconds(1), [this] { return stopping_; });
        ros::DiagnosticArray message{{system_now(), ""}, {}};
        for (const auto& [robot, status] : robots_) message.status.push_back(status);
        lock.unlock();
        for (const CameraState& state : tracker_.camera_states()) message.status.push_back(status_of(state));
        (void)participant_->publish(state_topic, ros::encode(message));  // the next one comes soon
        tell_cameras(message.header.stamp);
        participant_->tell_graph();
        lock.lock();
    }
}

void Ros2Sink::tell_cameras(Nanoseconds time) {
    for (std::size_t i = 0; i < tracker_.cameras(); ++i) {
        const SiteCamera& camera = tracker_.camera(i);
        if (camera.model.grid) continue;  // camera_info has no words for such a lens
        const std::string& word = camera_names_.of(camera.id);
        (void)participant_->publish("/" + word + "/camera_info", ros::encode(ros::camera_info_message(time, camera_frame(word), camera.model)));
    }
}

void Ros2Sink::stop() {
    {
        const std::lock_guard lock(mutex_);
        stopping_ = true;
    }
    changed_.notify_all();
    if (states_.joinable()) states_.join();
}

Result<void> Ros2Sink::finish() {
    stop();
    constexpr double longest = 2;  // s: a listener that has vanished is not waited for
    participant_->wait_until_received(longest);
    return {};
}

}  // namespace roomfix
