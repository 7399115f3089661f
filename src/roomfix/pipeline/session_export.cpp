#include "roomfix/pipeline/session_export.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <memory>
#include <set>
#include <utility>

#include "roomfix/base/text_file.hpp"
#include "roomfix/connect/frame_source.hpp"
#include "roomfix/connect/mcap_writer.hpp"
#include "roomfix/connect/ros_fix.hpp"
#include "roomfix/connect/ros_names.hpp"
#include "roomfix/connect/ros_type.hpp"
#include "roomfix/imaging/y4m.hpp"
#include "roomfix/pipeline/dead_reckoning_error.hpp"
#include "roomfix/pipeline/odometry_poses.hpp"
#include "roomfix/pipeline/recorded_senses.hpp"

namespace roomfix {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t most_notes = 20;

/// "jpeg" or "png", as it becomes in a message; nothing for other pictures.
std::string picture_format(const fs::path& file) {
    const std::string ending = file.extension().string();
    if (ending == ".jpg" || ending == ".jpeg" || ending == ".JPG" || ending == ".JPEG") return "jpeg";
    if (ending == ".y4m") return "jpeg";
    return ending == ".png" || ending == ".PNG" ? "png" : "";
}

/// A picture's file as a message can hold it.
Result<Bytes> picture_bytes(const fs::path& file) {
    const auto content = read_text(file);
    if (!content) return content.error();
    Bytes bytes(content->begin(), content->end());
    if (!is_y4m(bytes)) return bytes;
    constexpr int quality = 95;
    const auto view = y4m_view(bytes);
    if (!view) return Error{fmt::format("{}: {}", file.string(), view.error().message)};
    return encode_jpeg(*view, quality);
}

/// The messages of a session, gathered first and then written in the order of their times.
class Export {
public:
    Export(const Site& site, McapWriter& file);
    Result<void> gather(const SessionRecords& records);
    /// The site file goes along as an attachment.
    Result<void> write(const fs::path& site_file, const std::function<void(double)>& progress);
    ExportReport report() const;

private:
    struct Due {
        Nanoseconds time;
        std::string topic;
        RosType type;
        std::function<Result<Bytes>()> message;  // an error: it is left out
    };
    void add(Nanoseconds time, std::string topic, RosType type, std::function<Result<Bytes>()> message);
    void add_odometry(int robot);
    void add_fix(const Fix& fix);
    void add_transform(const Fix& fix);
    void add_truth(const TruePlace& place);
    void add_pictures(const SiteCamera& camera);
    void add_picture(const SiteCamera& camera, const fs::path& file, Nanoseconds time);
    RobotFrames frames(const std::string& robot) { return robot_frames(robots_.of(robot), site_.robots.size() == 1 && !site_.robots[0].many); }
    Result<std::uint16_t> channel(const std::string& topic, RosType type);
    void note(const std::string& sentence);
    void note_left_out();

    const Site& site_;
    McapWriter& file_;
    RosNames robots_, cameras_;
    std::map<std::string, std::vector<OdometryObservation>> odometry_;  // of each robot that has some
    std::map<std::pair<std::string, Nanoseconds>, const Fix*> newest_;  // the last that tells of a robot's place at a time
    std::vector<Due> due_;
    std::map<RosType, std::uint16_t> schemas_;
    std::map<std::string, std::uint16_t> channels_;
    std::vector<RecordedTopic> topics_;  // in the order of their channels
    std::vector<std::string> notes_;
    long beyond_time_ = 0, without_pose_ = 0, without_odometry_ = 0;
};

Export::Export(const Site& site, McapWriter& file) : site_(site), file_(file) {
    for (const SiteRobot& robot : site.robots) robots_.of(robot.id);
    for (const SiteCamera& camera : site.cameras) cameras_.of(camera.id);
}

void Export::note(const std::string& sentence) {
    if (notes_.size() < most_notes) notes_.push_back(sentence);
}

void Export::add(Nanoseconds time, std::string topic, RosType type, std::function<Result<Bytes>()> message) {
    if (ros::can_state(time)) {
        due_.push_back({time, std::move(topic), type, std::move(message)});
    } else {
        ++beyond_time_;
    }
}

Result<void> Export::gather(const SessionRecords& records) {
    const auto senses = RecordedSenses::load(site_);
    if (!senses) return senses.error();
    for (std::size_t r = 0; r < site_.robots.size(); ++r) {
        auto reports = senses->of(static_cast<int>(r)).odometry;
        if (!reports.empty()) odometry_[site_.robots[r].id] = std::move(reports);
    }
    for (const std::string& problem : senses->problems()) note("not used: " + problem);
    for (std::size_t r = 0; r < site_.robots.size(); ++r) add_odometry(static_cast<int>(r));
    for (const Fix& fix : records.fixes) add_fix(fix);
    for (const auto& [at, fix] : newest_) add_transform(*fix);
    for (const TruePlace& place : records.truth) add_truth(place);
    for (const SiteCamera& camera : site_.cameras) add_pictures(camera);
    std::stable_sort(due_.begin(), due_.end(), [](const Due& a, const Due& b) { return a.time < b.time; });
    note_left_out();
    return {};
}

void Export::note_left_out() {
    if (beyond_time_ > 0) note(fmt::format("{} records are before 1970 or after 2038: ROS cannot state such times", beyond_time_));
    if (without_pose_ > 0) note(fmt::format("{} fixes have no covariance that can be one (positive definite)", without_pose_));
    if (without_odometry_ > 0) {
        note(fmt::format("{} fixes have no odometry within a second of them: /tf says nothing about their times", without_odometry_));
    }
    if (due_.empty()) note("the session has nothing that can be exported: no fixes, no odometry, no truth, no pictures");
}

void Export::add_odometry(int robot) {
    const SiteRobot& site_robot = site_.robots[static_cast<std::size_t>(robot)];
    const auto found = odometry_.find(site_robot.id);
    if (found == odometry_.end()) return;
    const RobotFrames robot_has = frames(site_robot.id);
    DeadReckoningError error(site_robot.odometry.value_or(WheelOdometry{}));
    for (const OdometryObservation& report : found->second) {
        constexpr double unknown_speed = 1e3;  // m^2/s^2, rad^2/s^2: the reports are poses
        error.go_on(report);
        ros::Odometry message{{report.time, robot_has.odom}, robot_has.base, ros::pose_of(report.pose), ros::planar_covariance(error.covariance(), true)};
        for (std::size_t i = 0; i < 6; ++i) message.twist_covariance[7 * i] = unknown_speed;
        add(report.time, "/" + robots_.of(site_robot.id) + "/odom", RosType::odometry, [message] { return ros::encode(message); });
        const ros::TransformStamped moved = ros::transform_message(report.time, robot_has.odom, robot_has.base, report.pose);
        add(report.time, "/tf", RosType::tf_message, [moved] { return ros::encode(ros::TFMessage{{moved}}); });
    }
}

void Export::add_fix(const Fix& fix) {
    if (fix.status == FixStatus::none || fix.robot.empty()) return;
    if (!ros::has_pose(fix)) {
        ++without_pose_;
        return;
    }
    const ros::PoseWithCovarianceStamped message = ros::pose_message(fix);
    add(fix.time, "/" + robots_.of(fix.robot) + "/pose", RosType::pose_with_covariance_stamped, [message] { return ros::encode(message); });
    if (ros::has_twist(fix)) {
        const ros::Odometry moving = ros::odometry_message(fix, frames(fix.robot).base);
        add(fix.time, "/" + robots_.of(fix.robot) + "/odometry", RosType::odometry, [moving] { return ros::encode(moving); });
    }
    if (fix.yaw_known) newest_[{fix.robot, fix.time}] = &fix;
}

/// `map -> odom` where the robot has odometry, `map -> base_link` where it has none.
void Export::add_transform(const Fix& fix) {
    const auto reports = odometry_.find(fix.robot);
    ros::TransformStamped transform;
    if (reports == odometry_.end()) {
        transform = ros::transform_message(fix.time, map_frame, robots_.of(fix.robot) + "/base_link", fix.pose);
    } else {
        const auto odom_from_base = odometry_at(reports->second, fix.time);
        if (!odom_from_base) {
            ++without_odometry_;
            return;
        }
        transform = ros::transform_message(fix.time, map_frame, frames(fix.robot).odom, ros::map_from_odom(fix.pose, *odom_from_base));
    }
    add(fix.time, "/tf", RosType::tf_message, [transform] { return ros::encode(ros::TFMessage{{transform}}); });
}

void Export::add_truth(const TruePlace& place) {
    constexpr double exact = 1e-6;  // m^2, rad^2: a truth states no error, and ROS takes 0 for not known
    const ros::PoseWithCovarianceStamped message{
        {place.time, map_frame}, ros::pose_of(place.pose), ros::planar_covariance(exact * Eigen::Matrix3d::Identity(), place.yaw_known)};
    add(place.time, "/" + robots_.of(place.robot) + "/truth", RosType::pose_with_covariance_stamped, [message] { return ros::encode(message); });
}

void Export::add_pictures(const SiteCamera& camera) {
    const fs::path source = resolved_path(site_, camera.source);
    std::error_code failure;
    if (!fs::is_directory(source, failure)) {
        note(fmt::format("camera {}: no pictures: {} is no image folder", camera.id, source.string()));
        return;
    }
    const auto frames = open_source(source.string());
    if (!frames) {
        note(fmt::format("camera {}: no pictures: {}", camera.id, frames.error().message));
        return;
    }
    SourceFrame frame;
    for (auto more = (*frames)->advance(frame); more && *more; more = (*frames)->advance(frame)) add_picture(camera, source / frame.name, frame.time);
    if (camera.model.grid) note(fmt::format("camera {}: its lens is described by a grid, which camera_info cannot state", camera.id));
}

void Export::add_picture(const SiteCamera& camera, const fs::path& file, Nanoseconds time) {
    const std::string format = picture_format(file), word = cameras_.of(camera.id);
    if (format.empty()) {
        note(fmt::format("{}: not exported: a CompressedImage is JPEG or PNG", file.string()));
        return;
    }
    add(time, "/" + word + "/image/compressed", RosType::compressed_image, [=]() -> Result<Bytes> {
        auto bytes = picture_bytes(file);
        if (!bytes) return bytes.error();
        return ros::encode(ros::CompressedImage{{time, camera_frame(word)}, format, std::move(*bytes)});
    });
    const CameraModel* model = &camera.model;
    add(time, "/" + word + "/camera_info", RosType::camera_info, [=] { return ros::encode(ros::camera_info_message(time, camera_frame(word), *model)); });
}

/// The topic's channel, which it gets with its first message.
Result<std::uint16_t> Export::channel(const std::string& topic, RosType type) {
    if (const auto known = channels_.find(topic); known != channels_.end()) return known->second;
    const auto [schema, is_new] = schemas_.try_emplace(type, std::uint16_t{0});
    if (is_new) schema->second = file_.add_schema({ros_name_of(type), "ros2msg", ros_definition_of(type)});
    const auto channel = file_.add_channel({topic, "cdr", schema->second, {{"offered_qos_profiles", offered_qos_profiles()}}});
    if (!channel) return channel;
    channels_[topic] = *channel;
    topics_.push_back({topic, ros_name_of(type)});
    return channel;
}

Result<void> Export::write(const fs::path& site_file, const std::function<void(double)>& progress) {
    const auto site_text = read_text(site_file);
    if (!site_text) return site_text.error();
    const Nanoseconds start = due_.empty() ? 0 : due_.front().time;
    if (auto attached = file_.attach({"site.yaml", "application/yaml", *site_text, start}); !attached) return attached;
    for (std::size_t i = 0; i < due_.size(); ++i) {
        const auto message = due_[i].message();
        if (!message) {
            note("not exported: " + message.error().message);
            continue;
        }
        const auto id = channel(due_[i].topic, due_[i].type);
        if (!id) return id.error();
        if (auto written = file_.write(*id, due_[i].time, *message); !written) return written;
        if (progress) progress(static_cast<double>(i + 1) / static_cast<double>(due_.size()));
    }
    return file_.finish();
}

ExportReport Export::report() const {
    ExportReport report{{"", file_.start_time(), file_.end_time(), topics_}, notes_};
    for (std::size_t i = 0; i < topics_.size(); ++i) report.contents.topics[i].messages = file_.message_count(static_cast<std::uint16_t>(i + 1));
    return report;
}

Result<void> write_metadata(const fs::path& file, const BagContents& contents) {
    std::ofstream stream(file, std::ios::binary);
    stream << bag_metadata(contents);
    stream.close();
    if (stream) return {};
    return Error{fmt::format("{}: cannot be written: is the disk full?", file.string())};
}

}  // namespace

Result<ExportReport> export_mcap(const Site& site, const SessionRecords& records, const fs::path& file, const std::function<void(double)>& progress) {
    const auto mcap = McapWriter::create(file, "ros2");
    if (!mcap) return mcap.error();
    Export exported(site, **mcap);
    auto done = exported.gather(records);
    if (done) done = exported.write(records.site_file, progress);
    if (done) return exported.report();
    (*mcap)->abandon();
    return done.error();
}

Result<ExportReport> export_bag(const Site& site, const SessionRecords& records, const fs::path& folder, const std::function<void(double)>& progress) {
    std::error_code failure;
    const fs::path bag = fs::absolute(folder, failure).lexically_normal();
    const std::string name = bag.has_filename() ? bag.filename().string() : bag.parent_path().filename().string();
    if (!fs::create_directories(bag, failure)) {
        const std::string why = failure ? failure.message() : "it exists already: name a new one";
        return Error{fmt::format("{}: the folder cannot be made: {}", folder.string(), why)};
    }
    const std::string file = name + "_0.mcap";
    auto report = export_mcap(site, records, bag / file, progress);
    if (report) {
        report->contents.file = file;
        if (const auto written = write_metadata(bag / "metadata.yaml", report->contents); !written) report = written.error();
    }
    if (!report) fs::remove_all(bag, failure);
    return report;
}

}  // namespace roomfix
