#include "roomfix/site/read_camera.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "roomfix/base/decompositions.hpp"
#include "roomfix/site/lens_grid_file.hpp"

namespace roomfix {
namespace {

std::optional<Eigen::Isometry3d> read_pose(YamlReader& reader, const YAML::Node& node, const std::string& what) {
    const auto position = reader.point3(reader.required(node, "position", what), what + ".position");
    const auto q = reader.numbers(reader.required(node, "quaternion", what), what + ".quaternion", 4, -1.01, 1.01);
    if (!position || !q) return std::nullopt;
    const Eigen::Quaterniond quaternion((*q)[3], (*q)[0], (*q)[1], (*q)[2]);
    if (std::abs(quaternion.norm() - 1) > 1e-3) {
        reader.error(node["quaternion"], fmt::format("{}.quaternion has length {:.4f}, a rotation has 1: write [x, y, z, w]", what, quaternion.norm()));
        return std::nullopt;
    }
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.linear() = quaternion.normalized().toRotationMatrix();
    pose.translation() = *position;
    return pose;
}

/// A pose's covariance, if it is stated; zero otherwise.
std::optional<Matrix6d> read_covariance(YamlReader& reader, const YAML::Node& node, const std::string& what) {
    const auto c = reader.numbers(node["covariance"], what + ".covariance", 36, -1e6, 1e6);
    if (!c) return std::nullopt;
    const Matrix6d p = Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(c->data());
    const double largest = p.cwiseAbs().maxCoeff();
    const bool symmetric = (p - p.transpose()).cwiseAbs().maxCoeff() <= 1e-6 * largest;
    if (!symmetric || symmetric_eigen(p).eigenvalues()[0] < -1e-9 * largest) {
        reader.error(node["covariance"], what +
                                             ".covariance is not symmetric and positive: write it row by row, "
                                             "order x, y, z, rotation about x, y, z");
    }
    return p;
}

/// How a pose moves with `count` intrinsics, if that is stated; zero otherwise.
PoseByIntrinsics read_by_intrinsics(YamlReader& reader, const YAML::Node& node, int count, const std::string& what) {
    PoseByIntrinsics by = PoseByIntrinsics::Zero();
    const auto numbers = reader.numbers(node["by_intrinsics"], what + ".by_intrinsics", static_cast<std::size_t>(6 * count), -1e9, 1e9);
    if (!numbers) return by;
    by.leftCols(count) = Eigen::Map<const Eigen::Matrix<double, 6, Eigen::Dynamic, Eigen::RowMajor>>(numbers->data(), 6, count);
    return by;
}

std::optional<Placement> read_known_pose(YamlReader& reader, const YAML::Node& node, int intrinsics, const std::string& what) {
    if (!reader.map(node, what, {"position", "quaternion", "covariance", "by_intrinsics"})) return std::nullopt;
    const auto pose = read_pose(reader, node, what);
    const auto covariance = read_covariance(reader, node, what);
    if (!pose) return std::nullopt;
    return KnownPose{{*pose, covariance.value_or(Matrix6d::Zero())}, covariance.has_value(), read_by_intrinsics(reader, node, intrinsics, what)};
}

std::optional<Placement> read_floor_points(YamlReader& reader, const YAML::Node& node, const YAML::Node& sigma, const std::string& what) {
    if (!reader.list(node, what)) return std::nullopt;
    KnownFloorPoints floor;
    for (const auto& item : node) {
        const std::string name = fmt::format("{}[{}]", what, floor.points.size());
        if (!reader.map(item, name, {"pixel", "map"})) continue;
        const auto pixel = reader.point2(reader.required(item, "pixel", name), name + ".pixel");
        const auto map = reader.point2(reader.required(item, "map", name), name + ".map");
        floor.points.push_back({pixel.value_or(Eigen::Vector2d::Zero()), map.value_or(Eigen::Vector2d::Zero())});
    }
    if (const auto s = reader.number(sigma, what + "_sigma", 1e-3, 100)) floor.sigma = *s;
    return floor;
}

std::optional<Placement> read_placement(YamlReader& reader, const YAML::Node& node, int intrinsics, const std::string& what) {
    std::vector<std::string> given;
    for (const char* key : {"pose", "floor_points", "mount", "height"}) {
        if (node[key].IsDefined()) given.emplace_back(key);
    }
    if (given.size() != 1) {
        reader.error(node, given.empty() ? fmt::format("{} needs one of pose, floor_points, mount, height: where is the camera?", what)
                                         : fmt::format("{} has {}: keep one of them", what, fmt::join(given, " and ")));
        return std::nullopt;
    }
    const std::string inner = what + "." + given[0];
    if (given[0] == "pose") return read_known_pose(reader, node["pose"], intrinsics, inner);
    if (given[0] == "floor_points") return read_floor_points(reader, node["floor_points"], node["floor_points_sigma"], inner);
    if (given[0] == "mount") {
        if (!reader.map(node["mount"], inner, {"robot", "position", "quaternion", "covariance", "by_intrinsics"})) return std::nullopt;
        const auto robot = reader.text(reader.required(node["mount"], "robot", inner), inner + ".robot");
        const auto pose = read_pose(reader, node["mount"], inner);
        const auto covariance = read_covariance(reader, node["mount"], inner);
        if (!robot || !pose) return std::nullopt;
        return Mount{
            *robot, {*pose, covariance.value_or(Matrix6d::Zero())}, covariance.has_value(), read_by_intrinsics(reader, node["mount"], intrinsics, inner)};
    }
    KnownHeight known;
    known.height = reader.number(node["height"], inner, 0, tallest).value_or(1);
    known.sigma = reader.number(node["height_sigma"], what + ".height_sigma", 1e-6, 10).value_or(known.sigma);
    known.robot = reader.text(node["robot"], what + ".robot").value_or("");
    return known;
}

/// The lens: which model, its numbers, and how well they are known.
void read_lens(YamlReader& reader, const YAML::Node& node, const std::filesystem::path& folder, const std::string& what, SiteCamera& camera) {
    CameraModel& model = camera.model;
    const YAML::Node intrinsics = reader.required(node, "intrinsics", what);
    const bool is_map = intrinsics.IsDefined() && reader.map(intrinsics, what + ".intrinsics", {"fx", "fy", "cx", "cy", "covariance"});
    if (is_map) {
        const auto value = [&](const char* key, double least) {
            const std::string name = what + ".intrinsics." + key;
            return reader.number(reader.required(intrinsics, key, what + ".intrinsics"), name, least, 1e6).value_or(1);
        };
        model = {0, 0, value("fx", 1e-3), value("fy", 1e-3), value("cx", -1e6), value("cy", -1e6)};
    }
    if (const auto name = reader.text(node["distortion_model"], what + ".distortion_model")) {
        const auto kind = distortion_named(*name);
        if (!kind) {
            reader.error(node["distortion_model"],
                         fmt::format("{}.distortion_model is '{}': write plumb_bob, rational_polynomial or equidistant (fisheye)", what, *name));
        }
        model.kind = kind.value_or(Distortion::plumb_bob);
    }
    const auto numbers = static_cast<std::size_t>(distortion_count(model.kind));
    if (const auto d = reader.numbers(node["distortion"], what + ".distortion", numbers, -1e4, 1e4)) {
        std::copy(d->begin(), d->end(), model.distortion.begin());
    }
    if (const auto file = reader.text(node["lens_grid"], what + ".lens_grid")) {
        camera.lens_grid = *file;
        if (node["distortion"].IsDefined()) reader.error(node["lens_grid"], what + " has lens_grid and distortion: keep one of them");
        auto grid = load_lens_grid(folder / *file);
        if (!grid) reader.error(node["lens_grid"], grid.error().message);
        if (grid) model.grid = std::make_shared<const LensGrid>(std::move(*grid));
    }
    if (!is_map) return;
    const int count = model.intrinsics_count();
    const auto c = reader.numbers(intrinsics["covariance"], what + ".intrinsics.covariance", static_cast<std::size_t>(count * count), -1e12, 1e12);
    if (!c) return;
    const Eigen::MatrixXd p = Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(c->data(), count, count);
    // The numbers are of very different sizes: compared as correlations.
    const Eigen::VectorXd sigma = p.diagonal().cwiseMax(0).cwiseSqrt().cwiseMax(1e-300);
    const Eigen::MatrixXd correlation = sigma.cwiseInverse().asDiagonal() * p * sigma.cwiseInverse().asDiagonal();
    const bool symmetric = (correlation - correlation.transpose()).cwiseAbs().maxCoeff() <= 1e-6;
    if (!symmetric || p.diagonal().minCoeff() < 0 || symmetric_eigen(correlation).eigenvalues()[0] < -1e-6) {
        reader.error(intrinsics["covariance"],
                     what + ".intrinsics.covariance is not symmetric and positive: write it row by row, order fx, fy, cx, cy, then the distortion's numbers");
        return;
    }
    camera.intrinsics_covariance.topLeftCorner(count, count) = p;
}

constexpr double longest_readout = 0.2;  // s: more is a slip, such as milliseconds

/// How the camera takes its pictures.
CaptureSettings read_capture(YamlReader& reader, const YAML::Node& node, const std::string& what) {
    CaptureSettings capture;
    capture.delay = reader.number(node["delay"], what + ".delay", 0, 10);
    capture.readout = reader.number(node["readout"], what + ".readout", 0, longest_readout).value_or(0);
    const YAML::Node settings = node["capture"];
    if (!settings.IsDefined() || !reader.map(settings, what + ".capture", {"rate", "exposure", "gain", "white_balance"})) return capture;
    capture.rate = reader.number(settings["rate"], what + ".capture.rate", 0.1, 1000);
    capture.exposure = reader.number(settings["exposure"], what + ".capture.exposure", 1e-5, 1);
    capture.gain = reader.number(settings["gain"], what + ".capture.gain", 0, 1e6);
    capture.white_balance = reader.number(settings["white_balance"], what + ".capture.white_balance", 1000, 20000);
    return capture;
}

/// s, 1 sigma: nobody knows how late the pictures of a network camera come whose delay is not stated, unless it tells the time.
double usual_time_offset(const std::string& source, const CaptureSettings& capture) {
    constexpr double unknown_delay = 0.05;
    return source.find("://") != std::string::npos && !capture.delay ? unknown_delay : 0;
}

}  // namespace

void read_camera(YamlReader& reader, const std::string& id, const YAML::Node& node, Site& site) {
    const std::string what = "cameras." + id;
    if (!reader.map(node, what,
                    {"source", "size", "intrinsics", "distortion", "distortion_model", "lens_grid", "pose", "floor_points", "floor_points_sigma", "mount",
                     "height", "height_sigma", "robot", "background", "time_offset_sigma", "delay", "readout", "capture"})) {
        return;
    }
    SiteCamera camera;
    camera.id = id;
    camera.source = reader.text(reader.required(node, "source", what), what + ".source").value_or("");
    camera.capture = read_capture(reader, node, what);
    camera.time_offset_sigma =
        reader.number(node["time_offset_sigma"], what + ".time_offset_sigma", 0, 10).value_or(usual_time_offset(camera.source, camera.capture));
    camera.background = reader.text(node["background"], what + ".background").value_or("");
    const auto size = reader.numbers(reader.required(node, "size", what), what + ".size", 2, 1, 32768);
    read_lens(reader, node, site.folder, what, camera);
    if (size) {
        camera.model.width = static_cast<int>((*size)[0]);
        camera.model.height = static_cast<int>((*size)[1]);
    }
    camera.model.prepare();
    const auto placement = read_placement(reader, node, camera.model.intrinsics_count(), what);
    if (placement) camera.placement = *placement;
    if (const auto* floor = std::get_if<KnownFloorPoints>(&camera.placement); placement && floor && size && node["intrinsics"].IsDefined()) {
        std::string note;
        const auto view = fixed_view(camera, &note);
        if (!view) reader.error(node["floor_points"], view.error().message);
        if (!note.empty()) reader.warn(node["floor_points"], note);
    }
    site.cameras.push_back(camera);
}

}  // namespace roomfix
