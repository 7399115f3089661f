#include "roomfix/simulate/write_session.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "roomfix/base/number.hpp"
#include "roomfix/base/time.hpp"
#include "roomfix/imaging/load_luma.hpp"
#include "roomfix/site/site_text.hpp"

namespace roomfix {
namespace {

namespace fs = std::filesystem;

Result<void> write_text(const fs::path& file, const std::string& text) {
    std::ofstream stream(file, std::ios::binary);
    stream << text;
    if (!stream.flush()) return Error{fmt::format("{}: cannot be written: check the folder's permissions and room", file.string())};
    return {};
}

Result<void> write_frame(const fs::path& folder, Nanoseconds time, const LumaImage& frame, bool png) {
    const fs::path file = folder / fmt::format("{:012}.{}", time, png ? "png" : "jpg");
    return save_luma(file, frame);
}

/// ranges.csv, if a robot has a receiver.
Result<void> write_ranges(const Scenario& scenario, const fs::path& folder, double duration, std::uint64_t seed) {
    std::vector<RangeObservation> ranges;
    for (std::size_t r = 0; r < scenario.robots.size(); ++r) {
        const auto heard = heard_ranges(scenario, r, 0, duration, seed);
        ranges.insert(ranges.end(), heard.begin(), heard.end());
    }
    if (ranges.empty()) return {};
    std::stable_sort(ranges.begin(), ranges.end(), [](const auto& a, const auto& b) { return a.time < b.time; });
    std::string text = "time,robot,beacon,range,sigma\n";
    for (const RangeObservation& r : ranges) {
        text += fmt::format("{},{},{},{},{}\n", seconds_text(r.time), scenario.robots[static_cast<std::size_t>(r.robot)].robot.id,
                            scenario.site.beacons[static_cast<std::size_t>(r.beacon)].id, number_text(std::round(r.range * 1e5) / 1e5), number_text(r.sigma));
    }
    return write_text(folder / "ranges.csv", text);
}

/// odometry.csv, if a robot has odometry.
Result<void> write_odometry(const Scenario& scenario, const fs::path& folder, double duration, std::uint64_t seed) {
    std::vector<std::pair<WheelPose, std::string>> poses;
    for (std::size_t r = 0; r < scenario.robots.size(); ++r) {
        if (!scenario.robots[r].robot.odometry) continue;
        for (const WheelPose& pose : wheels_of(scenario, r, seed).until(duration)) poses.emplace_back(pose, scenario.robots[r].robot.id);
    }
    if (poses.empty()) return {};
    std::stable_sort(poses.begin(), poses.end(), [](const auto& a, const auto& b) { return a.first.time < b.first.time; });
    std::string text = "time,robot,x,y,yaw\n";
    const auto rounded = [](double value) { return number_text(std::round(value * 1e7) / 1e7); };
    for (const auto& [pose, robot] : poses) {
        text +=
            fmt::format("{},{},{},{},{}\n", seconds_text(from_seconds(pose.time)), robot, rounded(pose.pose.x), rounded(pose.pose.y), rounded(pose.pose.yaw));
    }
    return write_text(folder / "odometry.csv", text);
}

}  // namespace

Result<void> write_session(const Scenario& scenario, const fs::path& folder, const SessionOptions& options, const std::function<void(double)>& progress) {
    std::error_code failure;
    if (fs::exists(folder / "site.yaml", failure)) {
        return Error{fmt::format("{}: there is a session already: choose another folder or remove it", folder.string())};
    }
    for (const ScenarioCamera& camera : scenario.cameras) {
        fs::create_directories(folder / "frames" / camera.id, failure);
        fs::create_directories(folder / "background" / camera.id, failure);
        if (failure) return Error{fmt::format("{}: cannot be made: {}", folder.string(), failure.message())};
    }
    for (const ScenarioUpCamera& camera : scenario.up_cameras) {
        fs::create_directories(folder / "frames" / camera.id, failure);
        if (failure) return Error{fmt::format("{}: cannot be made: {}", folder.string(), failure.message())};
    }
    for (const ScenarioEye& eye : scenario.eyes) {
        fs::create_directories(folder / "frames" / eye.id, failure);
        if (failure) return Error{fmt::format("{}: cannot be made: {}", folder.string(), failure.message())};
    }
    if (auto written = write_text(folder / "site.yaml", site_text(scenario.site)); !written) return written;

    const double duration = options.duration > 0 ? options.duration : scenario.duration;
    const int frames = std::max(1, static_cast<int>(std::lround(duration * scenario.frame_rate)));
    std::string truth = "time,robot,x,y,yaw\n";
    for (int i = 0; i < frames; ++i) {
        const double time = i / scenario.frame_rate;
        for (std::size_t r = 0; r < scenario.robots.size(); ++r) {
            const Pose2 pose = true_pose(scenario, r, time);
            truth += fmt::format("{},{},{},{},{}\n", seconds_text(from_seconds(time)), scenario.robots[r].robot.id, number_text(pose.x), number_text(pose.y),
                                 number_text(pose.yaw));
        }
    }
    if (auto written = write_text(folder / "truth.csv", truth); !written) return written;

    if (auto written = write_ranges(scenario, folder, duration, options.seed); !written) return written;
    if (auto written = write_odometry(scenario, folder, duration, options.seed); !written) return written;

    const double total = static_cast<double>(scenario.cameras.size()) * (frames + options.background_frames) +
                         static_cast<double>(scenario.up_cameras.size() + scenario.eyes.size()) * frames;
    double done = 0;
    LumaImage frame;
    for (std::size_t c = 0; c < scenario.cameras.size(); ++c) {
        const ScenarioCamera& camera = scenario.cameras[c];
        const CameraRenderer renderer(scenario.scene, camera.truth, camera.sensor, options.seed * 31 + c);
        for (int i = 0; i < options.background_frames; ++i, ++done) {
            renderer.render({}, light_at(-0.1 * i, options.seed + c), 1'000'000 + static_cast<std::uint64_t>(i), frame);
            if (auto written = write_frame(folder / "background" / camera.id, from_seconds(0.1 * i), frame, options.png); !written) return written;
            if (progress) progress(done / total);
        }
        for (int i = 0; i < frames; ++i, ++done) {
            const double time = i / scenario.frame_rate;
            std::vector<Solid> solids;
            for (const ScenarioRobot& robot : scenario.robots) {
                const auto parts = robot_solids(robot.robot.shape, robot.look, robot_pose(robot, time));
                solids.insert(solids.end(), parts.begin(), parts.end());
            }
            renderer.render(solids, light_at(time, options.seed + c), static_cast<std::uint64_t>(i), frame);
            if (auto written = write_frame(folder / "frames" / camera.id, from_seconds(time), frame, options.png); !written) return written;
            if (progress) progress(done / total);
        }
    }
    for (std::size_t c = 0; c < scenario.up_cameras.size(); ++c) {
        const ScenarioUpCamera& camera = scenario.up_cameras[c];
        CeilingRenderer renderer(camera.truth.model, camera.sensor, camera.glare, options.seed * 37 + c);
        for (int i = 0; i < frames; ++i, ++done) {
            const double time = i / scenario.frame_rate;
            const Eigen::Isometry3d map_from_camera = map_from_robot(robot_pose(scenario.robots[camera.robot], time)) * camera.truth.robot_from_camera.pose;
            renderer.render(scenario.ceiling, map_from_camera, light_at(time, options.seed + 50 + c), static_cast<std::uint64_t>(i), frame);
            if (auto written = write_frame(folder / "frames" / camera.id, from_seconds(time), frame, options.png); !written) return written;
            if (progress) progress(done / total);
        }
    }
    for (std::size_t c = 0; c < scenario.eyes.size(); ++c) {
        const ScenarioEye& eye = scenario.eyes[c];
        RoomRenderer renderer(eye.truth.model, eye.sensor, eye.glare, options.seed * 41 + c);
        for (int i = 0; i < frames; ++i, ++done) {
            const double time = i / scenario.frame_rate;
            renderer.render(scenario.room, eye_pose(scenario, eye, time), light_at(time, options.seed + 80 + c), static_cast<std::uint64_t>(i), frame);
            if (auto written = write_frame(folder / "frames" / eye.id, from_seconds(time), frame, options.png); !written) return written;
            if (progress) progress(done / total);
        }
    }
    if (progress) progress(1);
    return {};
}

}  // namespace roomfix
