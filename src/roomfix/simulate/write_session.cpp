#include "roomfix/simulate/write_session.hpp"

#include <fmt/format.h>

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
    if (auto written = write_text(folder / "site.yaml", site_text(scenario.site)); !written) return written;

    const double duration = options.duration > 0 ? options.duration : scenario.duration;
    const int frames = std::max(1, static_cast<int>(std::lround(duration * scenario.frame_rate)));
    std::string truth = "time,robot,x,y,yaw\n";
    for (int i = 0; i < frames; ++i) {
        const double time = i / scenario.frame_rate;
        for (const ScenarioRobot& robot : scenario.robots) {
            const Pose2 pose = robot_pose(robot, time);
            truth += fmt::format("{},{},{},{},{}\n", seconds_text(from_seconds(time)), robot.robot.id, number_text(pose.x), number_text(pose.y),
                                 number_text(pose.yaw));
        }
    }
    if (auto written = write_text(folder / "truth.csv", truth); !written) return written;

    const double total = static_cast<double>(scenario.cameras.size()) * (frames + options.background_frames);
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
    if (progress) progress(1);
    return {};
}

}  // namespace roomfix
