// Luma to a corner's pose beside OpenCV's line segment detector, in one run.
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <numbers>
#include <opencv2/imgproc.hpp>

#include "medians.hpp"
#include "roomfix/corner/corner_observer.hpp"
#include "roomfix/evaluate/corner_bound.hpp"
#include "roomfix/geometry/pose.hpp"
#include "roomfix/simulate/room_shots.hpp"

namespace {

using namespace roomfix;

/// Pictures of the chou1986 experiment, or of furnished rooms, with what a tracker would expect.
struct Pictures {
    std::vector<LumaImage> frames;
    std::vector<CornerHints> hints;

    explicit Pictures(bool furnished) {
        Random random(furnished ? 77 : 78);
        RoomRenderer renderer(room_camera(), room_sensor(), {}, 5);
        for (std::size_t i = 0; frames.size() < 16; ++i) {
            const RoomShot shot = furnished ? cluttered_shot(random) : chou1986_shot(chou1986_places()[i % 16], random);
            renderer.render(shot.scene, shot.map_from_camera, shot.light, i, frames.emplace_back());
            // Expected one pixel off, as after a frame of driving.
            CornerHints hint;
            CornerView expected = true_view(shot);
            const double step = 0.5 / room_camera().fx;
            expected.corner_from_camera = exponential_rotation({random.normal(step), random.normal(step), random.normal(step)}) * expected.corner_from_camera;
            hint.expected.push_back({expected, std::numbers::pi / 2, 1.0});
            hints.push_back(hint);
        }
    }
};

const Pictures& pictures(bool furnished) {
    static const Pictures bare(false);
    static const Pictures full(true);
    return furnished ? full : bare;
}

/// `exact`: the lens's numbers are taken as they are, as CornerCamera does where the site states no covariance of them.
void observe(benchmark::State& state, bool furnished, bool predicted, bool exact = true) {
    const Pictures& p = pictures(furnished);
    CornerSettings settings;
    settings.by_intrinsics = !exact;
    CornerObserver observer(room_camera(), {std::numbers::pi / 2}, settings);
    CornerResult result;
    std::size_t i = 0;
    long found = 0;
    for (auto _ : state) {
        const std::size_t k = i++ % p.frames.size();
        observer.observe(p.frames[k], predicted ? p.hints[k] : CornerHints{}, result);
        found += predicted ? result.predicted : !result.corners.empty();
    }
    state.counters["found"] = static_cast<double>(found) / static_cast<double>(state.iterations());
}

void lsd(benchmark::State& state, bool furnished) {
    const Pictures& p = pictures(furnished);
    const auto detector = cv::createLineSegmentDetector();
    std::vector<cv::Vec4f> lines;
    std::size_t i = 0;
    for (auto _ : state) {
        const LumaImage& frame = p.frames[i++ % p.frames.size()];
        const cv::Mat picture(frame.height(), frame.width(), CV_8UC1, const_cast<std::uint8_t*>(frame.row(0)), static_cast<std::size_t>(frame.view().stride));
        detector->detect(picture, lines);
        benchmark::DoNotOptimize(lines);
    }
}

void bare_search(benchmark::State& state) { observe(state, false, false); }
void bare_predicted(benchmark::State& state) { observe(state, false, true); }
void bare_predicted_calibrated(benchmark::State& state) { observe(state, false, true, false); }
void furnished_search(benchmark::State& state) { observe(state, true, false); }
void bare_lsd(benchmark::State& state) { lsd(state, false); }
void furnished_lsd(benchmark::State& state) { lsd(state, true); }

BENCHMARK(bare_lsd)->Unit(benchmark::kMicrosecond);
BENCHMARK(bare_search)->Unit(benchmark::kMicrosecond);
BENCHMARK(bare_predicted)->Unit(benchmark::kMicrosecond);
BENCHMARK(bare_predicted_calibrated)->Unit(benchmark::kMicrosecond);
BENCHMARK(furnished_lsd)->Unit(benchmark::kMicrosecond);
BENCHMARK(furnished_search)->Unit(benchmark::kMicrosecond);

}  // namespace

int main(int argc, char** argv) {
    pictures(false);
    pictures(true);
    Medians medians;
    medians.run(argc, argv);
    auto& t = medians.times;
    const auto ratio = [&](const char* what, const char* incumbent, const char* ours, const char* goal) {
        if (t.count(incumbent) && t.count(ours)) fmt::print("OpenCV's LSD / luma to pose, 640 x 480, {}: {:.1f} ({})\n", what, t[incumbent] / t[ours], goal);
    };
    ratio("chou1986, no prediction", "bare_lsd", "bare_search", "goal at least 5");
    ratio("chou1986, predicted", "bare_lsd", "bare_predicted", "goal at least 50");
    ratio("chou1986, predicted, lens with a covariance", "bare_lsd", "bare_predicted_calibrated", "no goal");
    ratio("furnished rooms, no prediction", "furnished_lsd", "furnished_search", "no goal");
}
