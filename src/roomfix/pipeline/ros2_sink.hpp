// Fixes as ROS 2 topics: `/ROBOT/pose`, `/ROBOT/odometry`, `/tf`; beside them `/CAMERA/camera_info`, and the cameras' and robots' states as `/diagnostics`.
#pragma once

#include <condition_variable>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <thread>

#include "roomfix/connect/dds_participant.hpp"
#include "roomfix/connect/ros_message.hpp"
#include "roomfix/connect/ros_names.hpp"
#include "roomfix/pipeline/fix_sink.hpp"
#include "roomfix/pipeline/odom_corrections.hpp"
#include "roomfix/pipeline/site_tracker.hpp"

namespace roomfix {

class Ros2Sink final : public FixSink {
public:
    /// Joins the domain and offers the topics. `tracker`, whose cameras' states are told once a second, must outlive it. An error where the domain cannot
    /// be joined.
    static Result<std::unique_ptr<Ros2Sink>> open(const SiteTracker& tracker, const Ros2Output& settings);
    ~Ros2Sink() override;

    std::string name() const override;
    Result<void> give(const FixBatch& batch) override;
    Result<void> finish() override;

private:
    Ros2Sink(const SiteTracker& tracker, const Ros2Output& settings, std::unique_ptr<DdsParticipant> participant);
    Result<void> offer_topics();
    Result<void> offer_fixes(const std::string& robot);
    Result<void> give_fix(const Fix& fix);
    void forget_gone(const FixBatch& batch);
    Result<void> give_transforms(const FixBatch& batch);
    bool has_odometry(const std::string& robot) const;
    RobotFrames frames(const std::string& robot);
    void note_states(const FixBatch& batch);
    void tell_states();
    void tell_cameras(Nanoseconds time);
    void stop();

    const SiteTracker& tracker_;
    Ros2Output settings_;
    std::unique_ptr<DdsParticipant> participant_;
    RosNames names_;                                      // of robots
    RosNames camera_names_;                               // used by the thread of the states alone, once the topics are offered
    std::map<std::string, OdomCorrections> corrections_;  // of each robot with odometry, by its id
    std::map<std::string, Nanoseconds> last_transform_;   // of each robot without
    std::set<std::string> passing_;                       // robots that have a topic for as long as they are there: some of many

    std::mutex mutex_;  // guards:
    std::condition_variable changed_;
    bool stopping_ = false;
    std::map<std::string, ros::DiagnosticStatus> robots_;  // how each is at present
    std::thread states_;
};

}  // namespace roomfix
