#include "roomfix/simulate/write_session.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "roomfix/base/number.hpp"
#include "roomfix/base/time.hpp"
#include "roomfix/imaging/load_luma.hpp"
#include "roomfix/simulate/scenario_renderer.hpp"
#include "roomfix/simulate/truth_rows.hpp"
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
        const auto heard = heard_ranges(scenario, r, 0, std::min(duration, scenario.robots[r].until), seed);
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
        for (const WheelPose& pose : wheels_of(scenario, r, seed).until(std::min(duration, scenario.robots[r].until)))
            poses.emplace_back(pose, scenario.robots[r].robot.id);
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
    for (std::size_t i = 0; i < camera_count(scenario); ++i) {
        fs::create_directories(folder / "frames" / camera_id(scenario, i), failure);
        if (!failure && i < scenario.cameras.size()) fs::create_directories(folder / "background" / camera_id(scenario, i), failure);
        if (failure) return Error{fmt::format("{}: cannot be made: {}", folder.string(), failure.message())};
    }
    if (auto written = write_text(folder / "site.yaml", site_text(scenario.site)); !written) return written;

    const double duration = options.duration > 0 ? options.duration : scenario.duration;
    const int frames = std::max(1, static_cast<int>(std::lround(duration * scenario.frame_rate)));
    std::string truth = truth_header;
    for (int i = 0; i < frames; ++i) {
        const double time = i / scenario.frame_rate;
        truth += truth_rows(scenario, time, from_seconds(time));
    }
    if (auto written = write_text(folder / "truth.csv", truth); !written) return written;

    if (auto written = write_ranges(scenario, folder, duration, options.seed); !written) return written;
    if (auto written = write_odometry(scenario, folder, duration, options.seed); !written) return written;

    const double total = static_cast<double>(scenario.cameras.size()) * options.background_frames + static_cast<double>(camera_count(scenario)) * frames;
    double done = 0;
    LumaImage frame;
    for (std::size_t c = 0; c < camera_count(scenario); ++c) {
        const std::string& id = camera_id(scenario, c);
        ScenarioRenderer renderer(scenario, c, options.seed);
        for (int i = 0; i < options.background_frames && c < scenario.cameras.size(); ++i, ++done) {
            renderer.render_empty(static_cast<std::uint64_t>(i), frame);
            if (auto written = write_frame(folder / "background" / id, from_seconds(0.1 * i), frame, options.png); !written) return written;
            if (progress) progress(done / total);
        }
        for (int i = 0; i < frames; ++i, ++done) {
            const double time = i / scenario.frame_rate;
            renderer.render(time, static_cast<std::uint64_t>(i), frame);
            if (auto written = write_frame(folder / "frames" / id, from_seconds(time), frame, options.png); !written) return written;
            if (progress) progress(done / total);
        }
    }
    if (progress) progress(1);
    return {};
}

}  // namespace roomfix
