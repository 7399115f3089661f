// A frame of a camera that looks up to a fix, one thread, beside AprilTag detection in the same run. The last lines print the ratios.
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <cstring>

#include "medians.hpp"
#include "roomfix/ceiling/ceiling_observer.hpp"
#include "roomfix/ceiling/robot_locator.hpp"
#include "roomfix/imaging/tag_detector.hpp"
#include "roomfix/simulate/scenario.hpp"
#include "roomfix/simulate/tag_scene.hpp"

namespace {

using namespace roomfix;

/// The kim2011 room at one picture size: frames with a landmark and a lit tube, and the same frames with an AprilTag instead.
struct Room {
    std::vector<LumaImage> frames;
    std::vector<LumaImage> tag_frames;
    std::unique_ptr<CeilingObserver> observer;
    std::unique_ptr<RobotLocator> locator;
    std::vector<RangeObservation> ranges;
    LumaImage target;

    Room(int width, int height) {
        Scenario scenario = kim2011_scenario(1);
        const double focal = 0.5 * width / std::tan(radians(30));
        SiteCamera& described = scenario.site.cameras[0];
        described.model = make_camera_model(width, height, focal, focal, 0.5 * width, 0.5 * height, described.model.distortion);
        const auto& mount = std::get<Mount>(described.placement);
        const CameraOnRobot camera{described.model, mount.robot_from_camera};
        const ScenarioUpCamera& up = scenario.up_cameras[0];
        CeilingRenderer renderer(described.model, up.sensor, up.glare, 3);
        for (std::uint64_t i = 0; i < 9; ++i) {
            const Pose2 pose{0.6 + 0.09 * static_cast<double>(i), 1.0 + 0.05 * static_cast<double>(i), 0.7 * static_cast<double>(i)};
            const Eigen::Isometry3d map_from_camera = map_from_robot(pose) * up.truth.robot_from_camera.pose;
            LumaImage frame;
            renderer.render(scenario.ceiling, map_from_camera, 1, i, frame);
            frames.push_back(frame);
            CeilingScene plain = scenario.ceiling;
            plain.discs.clear();
            plain.patches.resize(1);  // the tube
            renderer.render(plain, map_from_camera, 1, i, frame);
            SiteLandmark tag{"t", Tag{7, 0.20}};
            tag.map_from_landmark.linear() << 0, 1, 0, 1, 0, 0, 0, 0, -1;
            tag.map_from_landmark.translation() = Eigen::Vector3d(1.0, 1.25, 3.0);
            paint_tag({described.model, {map_from_camera, Matrix6d::Zero()}}, tag.map_from_landmark, std::get<Tag>(tag.kind), 1.2, i, frame);
            tag_frames.push_back(std::move(frame));
        }
        observer = std::make_unique<CeilingObserver>(camera, true, scenario.site.landmarks);
        locator = std::make_unique<RobotLocator>(scenario.site, 0, camera);
        ranges = {{0, 0, 0, 2.72, 0.015}};
        target.resize(width, height);
    }
};

Room& room(int width) {
    static Room large(640, 480);
    static Room small(352, 288);
    return width == 640 ? large : small;
}

void luma_to_fix(benchmark::State& state) {
    Room& r = room(static_cast<int>(state.range(0)));
    CeilingResult seen;
    LocatedRobot located;
    std::size_t i = 0;
    for (auto _ : state) {
        r.observer->observe(r.frames[i++ % r.frames.size()], seen);
        r.locator->locate(seen.landmarks, {r.ranges.data(), r.ranges.size()}, {}, located);
        if (located.places.empty()) state.SkipWithError("the landmark was not found");
    }
}

void copy_frame(benchmark::State& state) {
    Room& r = room(static_cast<int>(state.range(0)));
    std::size_t i = 0;
    for (auto _ : state) {
        std::memcpy(r.target.row(0), r.frames[i++ % r.frames.size()].row(0),
                    static_cast<std::size_t>(r.target.view().stride) * static_cast<std::size_t>(r.target.height()));
        benchmark::ClobberMemory();
    }
}

void apriltag(benchmark::State& state) {
    Room& r = room(static_cast<int>(state.range(0)));
    TagDetector detector({TagFamily::tag36h11}, {.decimation = 2});
    std::vector<SeenTag> tags;
    std::size_t i = 0;
    for (auto _ : state) {
        detector.detect(r.tag_frames[i++ % r.tag_frames.size()], tags);
        if (tags.empty()) state.SkipWithError("the tag was not found");
    }
}

BENCHMARK(copy_frame)->Arg(352)->Arg(640)->Unit(benchmark::kMicrosecond);
BENCHMARK(luma_to_fix)->Arg(352)->Arg(640)->Unit(benchmark::kMicrosecond);
BENCHMARK(apriltag)->Arg(640)->Unit(benchmark::kMicrosecond);

}  // namespace

int main(int argc, char** argv) {
    room(640);  // before any clock runs
    Medians medians;
    medians.run(argc, argv);
    auto& t = medians.times;
    if (t.count("apriltag/640") && t.count("luma_to_fix/640")) {
        fmt::print("AprilTag (decimation 2) / luma to fix, 640 x 480: {:.0f} (goal at least 100)\n", t["apriltag/640"] / t["luma_to_fix/640"]);
    }
    if (t.count("copy_frame/352") && t.count("luma_to_fix/352")) {
        fmt::print("luma to fix, 352 x 288: {:.1f} us (goal at most 4 memcpys + 20 us = {:.1f} us)\n", t["luma_to_fix/352"], 4 * t["copy_frame/352"] + 20);
    }
}
