// A 1080p frame to an observation, one thread, beside OpenCV in the same run. The last lines print the ratios.
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <cstring>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/background_segm.hpp>

#include "medians.hpp"
#include "roomfix/imaging/load_luma.hpp"
#include "roomfix/overhead/overhead_observer.hpp"
#include "roomfix/simulate/scenario.hpp"

namespace {

using namespace roomfix;

/// The first aisle of the li2014 scenario seen in 1080p, one robot in view, still background. Several frames with their own
/// noise, so that no stage can profit from a frame that it knows; their number has no divisor in common with the passes of the
/// selective refresh, so that each part of the background sees them all.
struct Room {
    std::vector<LumaImage> frames;
    std::vector<LumaImage> empty;
    std::vector<std::vector<std::uint8_t>> jpegs;
    std::unique_ptr<OverheadObserver> observer;
    LumaImage target;

    Room() {
        fmt::print(stderr, "rendering 1080p frames ...\n");
        const Scenario scenario = li2014_scenario(1);
        View view = scenario.cameras[0].truth;
        view.model = make_camera_model(1920, 1080, 1555, 1555, 955, 540);
        const CameraRenderer renderer(scenario.scene, view, scenario.cameras[0].sensor, 7);
        BackgroundLearner learner;
        for (std::uint64_t i = 0; i < 24; ++i) {
            LumaImage frame;
            renderer.render({}, light_at(0.1 * static_cast<double>(i), 1), 1000 + i, frame);
            learner.add(frame);
            empty.push_back(std::move(frame));
        }
        RobotLook look = scenario.robots[0].look;
        look.top = 0.10f;  // dark on a light floor: the common case
        for (std::uint64_t i = 0; i < 9; ++i) {
            LumaImage frame;
            renderer.render(robot_solids(scenario.robots[0].robot.shape, look, {6.3 + 0.02 * static_cast<double>(i), 5.7, 0.3}), 1, i, frame);
            const cv::Mat grey(1080, 1920, CV_8UC1, frame.row(0), static_cast<std::size_t>(frame.view().stride));
            cv::Mat colour;
            cv::cvtColor(grey, colour, cv::COLOR_GRAY2BGR);
            jpegs.emplace_back();
            cv::imencode(".jpg", colour, jpegs.back(), {cv::IMWRITE_JPEG_QUALITY, 90});
            frames.push_back(std::move(frame));
        }
        observer = std::make_unique<OverheadObserver>(view, scenario.site.robots);
        observer->set_background(learner.learn());
        target.resize(1920, 1080);
    }
    cv::Mat mat(const LumaImage& image) const {
        return {1080, 1920, CV_8UC1, const_cast<std::uint8_t*>(image.row(0)), static_cast<std::size_t>(image.view().stride)};
    }
};

Room& room() {
    static Room shared;
    return shared;
}

std::size_t next_frame() {
    static std::size_t i = 0;
    return i++ % room().frames.size();
}

void check(benchmark::State& state, const OverheadResult& result) {
    if (result.observations.size() != 1) state.SkipWithError("the robot was not found");
}

void copy_frame(benchmark::State& state) {
    for (auto _ : state) {
        std::memcpy(room().target.row(0), room().frames[next_frame()].row(0), 1920 * 1080);
        benchmark::ClobberMemory();
    }
}

void classify_only(benchmark::State& state) {
    Foreground foreground;
    for (auto _ : state) room().observer->background().classify(room().frames[next_frame()], foreground);
}

void luma_to_observation(benchmark::State& state) {
    OverheadResult result;
    for (auto _ : state) room().observer->observe(room().frames[next_frame()], result);
    check(state, result);
}

void jpeg_to_observation(benchmark::State& state) {
    OverheadResult result;
    LumaImage frame;
    for (auto _ : state) {
        if (!decode_jpeg_luma(room().jpegs[next_frame()], frame)) state.SkipWithError("damaged");
        room().observer->observe(frame, result);
    }
    check(state, result);
}

/// What most projects do: opening, closing, connected components with statistics.
int blobs(const cv::Mat& mask) {
    static const cv::Mat square = cv::getStructuringElement(cv::MORPH_RECT, {3, 3});
    static cv::Mat clean, labels, statistics, centroids;
    cv::morphologyEx(mask, clean, cv::MORPH_OPEN, square);
    cv::morphologyEx(clean, clean, cv::MORPH_CLOSE, square);
    return cv::connectedComponentsWithStats(clean, labels, statistics, centroids);
}

void opencv_difference(benchmark::State& state) {
    cv::setNumThreads(1);
    const cv::Mat background = room().mat(room().empty[0]);
    cv::Mat difference, mask;
    for (auto _ : state) {
        cv::absdiff(room().mat(room().frames[next_frame()]), background, difference);
        cv::threshold(difference, mask, 25, 255, cv::THRESH_BINARY);
        benchmark::DoNotOptimize(blobs(mask));
    }
}

cv::Ptr<cv::BackgroundSubtractorMOG2> trained_mog2() {
    auto mog2 = cv::createBackgroundSubtractorMOG2();
    cv::Mat mask;
    for (const auto& frame : room().empty) mog2->apply(room().mat(frame), mask);
    return mog2;
}

void opencv_mog2(benchmark::State& state) {
    cv::setNumThreads(1);
    const auto mog2 = trained_mog2();
    cv::Mat mask;
    for (auto _ : state) {
        mog2->apply(room().mat(room().frames[next_frame()]), mask);
        benchmark::DoNotOptimize(blobs(mask));
    }
}

void opencv_jpeg_mog2(benchmark::State& state) {
    cv::setNumThreads(1);
    auto mog2 = cv::createBackgroundSubtractorMOG2();
    cv::Mat mask, colour;
    for (const auto& frame : room().empty) {
        cv::cvtColor(room().mat(frame), colour, cv::COLOR_GRAY2BGR);
        mog2->apply(colour, mask);
    }
    for (auto _ : state) {
        const cv::Mat picture = cv::imdecode(room().jpegs[next_frame()], cv::IMREAD_COLOR);
        mog2->apply(picture, mask);
        benchmark::DoNotOptimize(blobs(mask));
    }
}

BENCHMARK(copy_frame)->Unit(benchmark::kMicrosecond);
BENCHMARK(classify_only)->Unit(benchmark::kMicrosecond);
BENCHMARK(luma_to_observation)->Unit(benchmark::kMicrosecond);
BENCHMARK(jpeg_to_observation)->Unit(benchmark::kMicrosecond);
BENCHMARK(opencv_difference)->Unit(benchmark::kMicrosecond);
BENCHMARK(opencv_mog2)->Unit(benchmark::kMicrosecond);
BENCHMARK(opencv_jpeg_mog2)->Unit(benchmark::kMicrosecond);

}  // namespace

int main(int argc, char** argv) {
    room();  // before any clock runs
    Medians medians;
    medians.run(argc, argv);
    auto& t = medians.times;
    const auto ratio = [&](const char* text, const char* a, const char* b, const char* goal) {
        if (t.count(a) && t.count(b)) fmt::print("{}: {:.2f} (goal {})\n", text, t[a] / t[b], goal);
    };
    ratio("luma to observation / memcpy of the frame", "luma_to_observation", "copy_frame", "at most 3");
    ratio("absdiff + threshold + open + close + components / luma to observation", "opencv_difference", "luma_to_observation", "at least 40");
    ratio("MOG2 + open + close + components / luma to observation", "opencv_mog2", "luma_to_observation", "at least 90");
    ratio("imdecode + MOG2 + open + close + components / JPEG to observation", "opencv_jpeg_mog2", "jpeg_to_observation", "at least 5");
    return 0;
}
