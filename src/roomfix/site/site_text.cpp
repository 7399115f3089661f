#include "roomfix/site/site_text.hpp"

#include <fmt/format.h>

#include <span>

#include "roomfix/base/number.hpp"
#include "roomfix/site/outputs_text.hpp"
#include "roomfix/site/read_plan.hpp"

namespace roomfix {
namespace {

template <class Range>
std::string list_text(const Range& values) {
    std::string text = "[";
    for (const double v : values) text += (text.size() > 1 ? ", " : "") + number_text(v);
    return text + "]";
}

std::string transform_text(const Eigen::Isometry3d& pose) {
    const Eigen::Quaterniond q(pose.linear());
    const Eigen::Vector3d p = pose.translation();
    return fmt::format("position: {}, quaternion: {}", list_text(std::array{p.x(), p.y(), p.z()}), list_text(std::array{q.x(), q.y(), q.z(), q.w()}));
}

std::string covariance_text(const Matrix6d& covariance) {
    const Eigen::Matrix<double, 6, 6, Eigen::RowMajor> p = covariance;
    return ", covariance: " + list_text(std::vector<double>(p.data(), p.data() + 36));
}

std::string by_intrinsics_text(const PoseByIntrinsics& by, int count) {
    if (by.isZero(0)) return "";
    const Eigen::Matrix<double, 6, Eigen::Dynamic, Eigen::RowMajor> rows = by.leftCols(count);
    return ", by_intrinsics: " + list_text(std::span(rows.data(), static_cast<std::size_t>(rows.size())));
}

struct PlacementText {
    const CameraModel& model;

    std::string operator()(const KnownPose& known) const { return "    pose: " + roomfix::pose_text(known, model) + "\n"; }
    std::string operator()(const KnownFloorPoints& floor) const {
        std::string text = fmt::format("    floor_points_sigma: {}\n    floor_points:\n", number_text(floor.sigma));
        for (const FloorPoint& p : floor.points) {
            text += fmt::format("      - {{pixel: {}, map: {}}}\n", list_text(p.pixel), list_text(p.map));
        }
        return text;
    }
    std::string operator()(const Mount& mount) const { return "    mount: " + mount_text(mount, model) + "\n"; }
    std::string operator()(const KnownHeight& known) const {
        return fmt::format("    height: {}\n    height_sigma: {}\n{}", number_text(known.height), number_text(known.sigma),
                           known.robot.empty() ? "" : "    robot: " + known.robot + "\n");
    }
};

std::string capture_text(const CaptureSettings& capture) {
    std::string text, settings;
    if (capture.readout > 0) text += "    readout: " + number_text(capture.readout) + "\n";
    if (capture.delay) text += "    delay: " + number_text(*capture.delay) + "\n";
    const auto add = [&](const char* key, const std::optional<double>& value) {
        if (value) settings += (settings.empty() ? "" : ", ") + (key + (": " + number_text(*value)));
    };
    add("rate", capture.rate);
    add("exposure", capture.exposure);
    add("gain", capture.gain);
    add("white_balance", capture.white_balance);
    return settings.empty() ? text : text + "    capture: {" + settings + "}\n";
}

std::string camera_text(const SiteCamera& camera) {
    const CameraModel& m = camera.model;
    std::string text = fmt::format("  {}:\n    source: {}\n    size: [{}, {}]\n", camera.id, camera.source, m.width, m.height);
    text += "    intrinsics: " + intrinsics_text(m, camera.intrinsics_covariance) + "\n";
    if (m.kind != Distortion::plumb_bob) text += fmt::format("    distortion_model: {}\n", name_of(m.kind));
    text += camera.lens_grid.empty() ? "    distortion: " + distortion_text(m) + "\n" : "    lens_grid: " + camera.lens_grid + "\n";
    text += std::visit(PlacementText{camera.model}, camera.placement);
    if (camera.time_offset_sigma > 0) text += "    time_offset_sigma: " + number_text(camera.time_offset_sigma) + "\n";
    text += capture_text(camera.capture);
    if (!camera.background.empty()) text += "    background: " + camera.background + "\n";
    return text;
}

double yaw_of(const Eigen::Vector3d& direction) { return degrees(std::atan2(direction.y(), direction.x())); }

std::string shape_text(const Shape& shape) {
    if (const auto* box = std::get_if<Box>(&shape)) return "shape: box, size: " + list_text(std::array{box->length, box->width, box->height});
    const auto& cylinder = std::get<Cylinder>(shape);
    return "shape: cylinder, size: " + list_text(std::array{cylinder.diameter, cylinder.height});
}

std::string body_text(const SiteRobot& robot) {
    if (!robot.learned_body.empty()) return "model: " + robot.learned_body;
    if (!robot.model.empty()) {
        return "model: " + robot.model + (robot.model_scale != 1 ? ", model_scale: " + number_text(robot.model_scale) : "");
    }
    return robot.parts.empty() ? shape_text(robot.shape) : "parts: " + parts_text(robot.parts);
}

std::string receiver_text(const Receiver& receiver, const SiteRobot& robot) {
    std::string text;
    const auto add = [&](const std::string& key, const std::string& value) { text += (text.empty() ? "" : ", ") + key + ": " + value; };
    const Receiver anywhere = somewhere_on(robot);
    const bool known = receiver.position != anywhere.position || receiver.position_sigma != anywhere.position_sigma;
    if (known) add("position", list_text(receiver.position));
    if (known && receiver.position_sigma.x() > 0) add("position_sigma", number_text(receiver.position_sigma.x()));
    add("sigma", number_text(receiver.sigma));
    if (receiver.bias_sigma > 0) add("bias_sigma", number_text(receiver.bias_sigma));
    if (receiver.scale_sigma > 0) add("scale_sigma", number_text(receiver.scale_sigma));
    if (!receiver.source.empty()) add("source", receiver.source);
    return "{" + text + "}";
}

std::string detector_text(const Detector& detector) {
    std::string text = fmt::format("range_sigma: {}, bearing_sigma: {}", number_text(detector.range_sigma), number_text(detector.bearing_sigma));
    if (!detector.position.isZero(0)) text += ", position: " + list_text(detector.position);
    if (detector.position_sigma.x() > 0) text += ", position_sigma: " + number_text(detector.position_sigma.x());
    if (!detector.source.empty()) text += ", source: " + detector.source;
    return "{" + text + "}";
}

std::string robot_text(const SiteRobot& robot) {
    std::string text =
        fmt::format("  {}:\n    {{{}, size_sigma: {}{}", robot.id, body_text(robot), number_text(robot.size_sigma), robot.many ? ", count: many" : "");
    if (robot.drive != Drive::unknown) text += robot.drive == Drive::differential ? ", drive: differential" : ", drive: holonomic";
    for (const auto& [key, value] : senses_text(robot)) text += fmt::format(",\n     {}: {}", key, value);
    if (robot.tag) {
        text +=
            fmt::format(",\n     tag: {{id: {}, family: {}, size: {}, position: {}, yaw_deg: {}}}", robot.tag->number, name_of(robot.tag->family),
                        number_text(robot.tag->size), list_text(robot.robot_from_tag.translation()), number_text(yaw_of(robot.robot_from_tag.linear().col(1))));
    }
    return text + "}\n";
}

std::string landmark_text(const SiteLandmark& landmark) {
    const Eigen::Isometry3d& pose = landmark.map_from_landmark;
    std::string text = fmt::format("  {}: {{position: {}, sigma: {}", landmark.id, list_text(pose.translation()), number_text(landmark.sigma));
    if (const auto* triangle = std::get_if<LedTriangle>(&landmark.kind)) {
        text += fmt::format(", yaw_deg: {}, legs: {}", number_text(yaw_of(pose.linear().col(0))), list_text(std::array{triangle->a, triangle->b}));
    } else if (const auto* tag = std::get_if<Tag>(&landmark.kind)) {
        const double out = pose.linear()(2, 2);
        const bool wall = std::abs(out) < 0.5;
        text += fmt::format(", yaw_deg: {}, tag: {}, family: {}, size: {}, facing: {}, tilt_sigma_deg: {}",
                            number_text(yaw_of(pose.linear().col(wall ? 2 : 1))), tag->number, name_of(tag->family), number_text(tag->size),
                            wall      ? "wall"
                            : out > 0 ? "up"
                                      : "down",
                            number_text(degrees(landmark.tilt_sigma)));
    }
    return text + (landmark.beacon.empty() ? "" : ", beacon: " + landmark.beacon) + "}\n";
}

}  // namespace

std::string points_text(const Polyline& points) {
    std::string text = "[";
    for (std::size_t i = 0; i < points.size(); ++i) text += (i ? ", " : "") + list_text(points[i]);
    return text + "]";
}

std::string parts_text(const std::vector<ConvexPart>& parts) {
    std::string text = "[";
    for (const ConvexPart& part : parts) {
        text += &part == &parts.front() ? "" : ",\n             ";
        text += "{points: [";
        for (const auto& p : part.points) text += (&p == &part.points.front() ? "" : ", ") + list_text(p);
        text += "]}";
    }
    return text + "]";
}

std::vector<std::pair<std::string, std::string>> senses_text(const SiteRobot& robot) {
    std::vector<std::pair<std::string, std::string>> all;
    if (robot.odometry) {
        all.emplace_back("odometry", fmt::format("{{scale_sigma: {}, turn_scale_sigma: {}, drift_sigma: {}{}}}", number_text(robot.odometry->scale_sigma),
                                                 number_text(robot.odometry->turn_scale_sigma), number_text(robot.odometry->drift_sigma),
                                                 robot.odometry->source.empty() ? "" : ", source: " + robot.odometry->source));
    }
    if (robot.receivers.size() == 1 && robot.receivers[0].id.empty()) {
        all.emplace_back("receiver", receiver_text(robot.receivers[0], robot));
    } else if (!robot.receivers.empty()) {
        std::string text;
        for (const Receiver& r : robot.receivers) text += fmt::format("{}{}: {}", text.empty() ? "" : ", ", r.id, receiver_text(r, robot));
        all.emplace_back("receivers", "{" + text + "}");
    }
    if (robot.detector) all.emplace_back("detector", detector_text(*robot.detector));
    return all;
}

std::string mount_text(const Mount& mount, const CameraModel& model) {
    return fmt::format("{{robot: {}, {}{}{}}}", mount.robot, transform_text(mount.robot_from_camera.pose),
                       mount.has_covariance ? covariance_text(mount.robot_from_camera.covariance) : "",
                       by_intrinsics_text(mount.by_intrinsics, model.intrinsics_count()));
}

std::string pose_text(const KnownPose& known, const CameraModel& model) {
    return fmt::format("{{{}{}{}}}", transform_text(known.map_from_camera.pose), known.has_covariance ? covariance_text(known.map_from_camera.covariance) : "",
                       by_intrinsics_text(known.by_intrinsics, model.intrinsics_count()));
}

std::string intrinsics_text(const CameraModel& model, const IntrinsicsMatrix& covariance) {
    std::string text =
        fmt::format("{{fx: {}, fy: {}, cx: {}, cy: {}", number_text(model.fx), number_text(model.fy), number_text(model.cx), number_text(model.cy));
    if (!covariance.isZero(0)) {
        const int count = model.intrinsics_count();
        const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> rows = covariance.topLeftCorner(count, count);
        text += ", covariance: " + list_text(std::span(rows.data(), static_cast<std::size_t>(rows.size())));
    }
    return text + "}";
}

std::string distortion_text(const CameraModel& model) {
    return list_text(std::span(model.distortion).first(static_cast<std::size_t>(distortion_count(model.kind))));
}

std::string site_text(const Site& site) {
    std::string text = fmt::format("roomfix: 1\nsite:\n  name: {}\n", site.name);
    if (site.ceiling > 0) text += "  ceiling: " + number_text(site.ceiling) + "\n";
    if (site.temperature != Site().temperature) text += "  temperature: " + number_text(site.temperature) + "\n";
    if (site.lost != Site().lost) text += "  lost: " + number_text(site.lost) + "\n";
    if (!site.walls.empty()) {
        text += "  walls:\n";
        for (const Polyline& line : site.walls) {
            text += "    - " + points_text(line) + "\n";
        }
    }
    if (!site.cameras.empty()) text += "cameras:\n";
    for (const auto& camera : site.cameras) text += camera_text(camera);
    if (!site.robots.empty()) text += "robots:\n";
    for (const auto& robot : site.robots) text += robot_text(robot);
    if (!site.beacons.empty()) text += "beacons:\n";
    for (const auto& b : site.beacons) {
        text += fmt::format("  {}: {{position: {}{}}}\n", b.id, list_text(b.position), b.address.empty() ? "" : ", address: \"" + b.address + "\"");
    }
    if (!site.landmarks.empty()) text += "landmarks:\n";
    for (const auto& l : site.landmarks) text += landmark_text(l);
    if (!site.corners.empty()) text += "corners:\n";
    for (const auto& c : site.corners) {
        text += fmt::format("  {}: {{position: {}, yaw_deg: {}, angle_deg: {}, sigma: {}{}}}\n", c.id, list_text(c.position), number_text(degrees(c.yaw)),
                            number_text(degrees(c.wall_angle)), number_text(c.sigma), c.moulding ? ", moulding: " + number_text(*c.moulding) : "");
    }
    if (!site.zones.empty()) text += "zones:\n";
    for (const SiteZone& zone : site.zones) text += fmt::format("  {}: {}\n", zone.id, points_text(zone.border));
    if (site.plan) text += "plan: " + plan_text(*site.plan) + "\n";
    text += outputs_text(site.outputs);
    return text;
}

}  // namespace roomfix
