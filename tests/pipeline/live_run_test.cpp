// A camera of a rendered building on the network: it is not there when the run starts, comes, is killed, and comes back.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <functional>
#include <mutex>
#include <thread>

#include "connect/peer.hpp"
#include "roomfix/connect/time_errors.hpp"
#include "roomfix/imaging/load_luma.hpp"
#include "roomfix/pipeline/session_recorder.hpp"
#include "roomfix/pipeline/source_runner.hpp"
#include "roomfix/simulate/scenario_renderer.hpp"
#include "roomfix/site/load_site.hpp"
#include "roomfix/site/site_text.hpp"

namespace roomfix {
namespace {

namespace fs = std::filesystem;

/// The rendered pictures of a drive to and fro, shown by the clock.
class Film {
public:
    explicit Film(const Scenario& scenario) : scenario_(scenario), renderer_(scenario, 0, 5) {
        for (int i = 0; i < count; ++i) {
            LumaImage picture;
            renderer_.render(start + i * interval, static_cast<std::uint64_t>(i), picture);
            pictures_.push_back(std::move(picture));
        }
    }
    BackgroundModel background() {
        BackgroundLearner learner;
        LumaImage picture;
        for (std::uint64_t i = 0; i < 20; ++i) {
            renderer_.render_empty(i, picture);
            learner.add(picture);
        }
        return learner.learn();
    }
    const LumaImage& picture(int number) const { return pictures_[static_cast<std::size_t>(index_of(number))]; }
    /// The robot's pose at a time of the clock.
    Pose2 truth(Nanoseconds time) const {
        const double number = to_seconds(time - first_) / interval;
        const double period = 2.0 * (count - 1);
        const double within = std::fmod(number, period);
        return robot_pose(scenario_.robots[0], start + interval * std::min(within, period - within));
    }
    Nanoseconds time_of(int number) const { return first_ + from_seconds(number * interval); }

    static constexpr double interval = 0.08;  // s

private:
    static constexpr int count = 24;
    static constexpr double start = 1;  // s of the scenario
    static int index_of(int number) {
        const int within = number % (2 * (count - 1));
        return std::min(within, 2 * (count - 1) - within);
    }
    const Scenario& scenario_;
    ScenarioRenderer renderer_;
    std::vector<LumaImage> pictures_;
    Nanoseconds first_ = system_now();
};

/// Shows the film to a server, each picture when it is due.
class FilmCamera {
public:
    FilmCamera(const Film& film, const Peer& server) : thread_([this, &film, &server] { run(film, server); }) {}
    ~FilmCamera() {
        stop_ = true;
        thread_.join();
    }
    FilmCamera(const FilmCamera&) = delete;
    FilmCamera& operator=(const FilmCamera&) = delete;

private:
    void run(const Film& film, const Peer& server) {
        const LumaImage& first = film.picture(0);
        const auto pixels = static_cast<std::size_t>(first.width() * first.height());
        std::vector<std::uint8_t> message(sizeof(Nanoseconds) + pixels * 3 / 2, 116);                                                      // bluish ...
        std::fill(message.begin() + static_cast<std::ptrdiff_t>(sizeof(Nanoseconds) + pixels * 5 / 4), message.end(), std::uint8_t{140});  // ... red
        while (!stop_) {
            int number = 0;
            while (film.time_of(number) < system_now()) ++number;
            const Nanoseconds time = film.time_of(number);
            std::this_thread::sleep_for(std::chrono::nanoseconds(time - system_now()));
            std::memcpy(message.data(), &time, sizeof time);
            std::uint8_t* to = message.data() + sizeof time;
            for (int y = 0; y < first.height(); ++y) {
                for (int x = 0; x < first.width(); ++x) *to++ = static_cast<std::uint8_t>(16 + film.picture(number).row(y)[x] * 219 / 255);
            }
            if (!server.write(message)) return;
        }
    }
    std::atomic<bool> stop_{false};
    std::thread thread_;
};

/// Keeps what it gets.
class KeptFixes final : public FixSink {
public:
    struct Kept {
        std::mutex mutex;
        std::vector<Fix> fixes;
        std::size_t batches = 0;

        std::size_t found() {
            const std::lock_guard lock(mutex);
            return static_cast<std::size_t>(std::count_if(fixes.begin(), fixes.end(), [](const Fix& f) { return f.status == FixStatus::ok; }));
        }
    };
    explicit KeptFixes(Kept& kept) : kept_(kept) {}
    Result<void> give(const FixBatch& batch) override {
        const std::lock_guard lock(kept_.mutex);
        kept_.fixes.insert(kept_.fixes.end(), batch.given.begin(), batch.given.end());
        ++kept_.batches;
        return {};
    }

private:
    Kept& kept_;
};

/// True once something holds; false if it does not within half a minute.
bool wait_for(const std::function<bool()>& holds) {
    const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(30);
    while (!holds()) {
        if (std::chrono::steady_clock::now() > until) return false;
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return true;
}

/// A recording of the site's only camera, in a folder that is gone with it.
struct LiveRecording {
    fs::path folder = fs::temp_directory_path() / fmt::format("roomfix_live_{}", getpid());
    std::unique_ptr<SessionRecorder> recorder;

    explicit LiveRecording(Site site) {
        fs::remove_all(folder);
        const std::string camera = site.cameras[0].id;
        site.cameras[0].source = "frames/" + camera;
        site.cameras[0].background.clear();
        auto started = SessionRecorder::start({folder}, {site, site_text(site), {camera}, {}});
        if (started) recorder = std::move(*started);
    }
    ~LiveRecording() { fs::remove_all(folder); }
    LiveRecording(const LiveRecording&) = delete;
    LiveRecording& operator=(const LiveRecording&) = delete;
};

/// The fixes of a recording.
std::vector<Fix> replayed(const fs::path& session, const BackgroundModel& background) {
    const auto site = load_session(session);
    if (!site) ADD_FAILURE() << site.error().message;
    auto tracker = SiteTracker::create(*site);
    (*tracker)->set_background(0, background);
    SourceRunner runner(**tracker);
    KeptFixes::Kept kept;
    runner.add_sink(std::make_unique<KeptFixes>(kept), Overflow::wait);
    RunSettings settings;
    settings.speed = 0;
    const std::atomic<bool> stop{false};
    EXPECT_TRUE(runner.run(settings, stop));
    EXPECT_TRUE(runner.finish_sinks());
    return kept.fixes;
}

/// Every fix that was given live and rests on a frame is given again, to the last digit.
void expect_same_fixes(const std::vector<Fix>& live, const std::vector<Fix>& again) {
    std::size_t same = 0;
    for (const Fix& fix : live) {
        if (fix.status != FixStatus::ok) continue;
        const auto found = std::find_if(again.begin(), again.end(), [&](const Fix& f) { return f.time == fix.time && f.robot == fix.robot; });
        ASSERT_NE(found, again.end()) << fix.time;
        EXPECT_EQ(found->pose.x, fix.pose.x);
        EXPECT_EQ(found->pose.y, fix.pose.y);
        EXPECT_EQ(found->pose.yaw, fix.pose.yaw);
        EXPECT_EQ(found->covariance, fix.covariance);
        ++same;
    }
    EXPECT_GT(same, 15U);
}

/// Pictures of a decoded stream are kept as they were decoded, with their colours.
void expect_colours(const fs::path& frames) {
    std::size_t pictures = 0;
    for (const auto& file : fs::directory_iterator(frames)) {
        if (file.path().filename() == time_errors_name) continue;
        LumaImage grey;
        ColourImage colour;
        std::vector<std::uint8_t> buffer;
        EXPECT_EQ(file.path().extension(), ".y4m");
        ASSERT_TRUE(load_picture(file, grey, colour, buffer));
        EXPECT_EQ(colour.channels, 3);
        ++pictures;
    }
    EXPECT_GT(pictures, 15U);
}

/// Runs the site's sources in a thread until it goes.
class Running {
public:
    explicit Running(SourceRunner& runner)
        : thread_([this, &runner] {
              RunSettings settings;
              settings.on_time = true;
              const auto ran = runner.run(settings, stop_);
              if (!ran) ADD_FAILURE() << ran.error().message;
          }) {}
    ~Running() {
        stop_ = true;
        thread_.join();
    }
    Running(const Running&) = delete;
    Running& operator=(const Running&) = delete;

private:
    std::atomic<bool> stop_{false};
    std::thread thread_;
};

TEST(LiveRun, ANetworkCameraThatComesGoesAndComesBackFindsTheRobotWhereItIs) {
    ::signal(SIGPIPE, SIG_IGN);
    const Scenario scenario = li2014_scenario(3);
    const int port = free_port();
    Site site = scenario.site;
    site.cameras.resize(1);
    for (SiteRobot& robot : site.robots) robot.odometry.reset();  // its cameras alone find it
    site.cameras[0].source = fmt::format("rtsp://127.0.0.1:{}/camera", port);
    Film film(scenario);
    auto tracker = SiteTracker::create(site);
    ASSERT_TRUE(tracker) << tracker.error().message;
    const BackgroundModel background = film.background();
    (*tracker)->set_background(0, background);
    LiveRecording recording(site);
    ASSERT_TRUE(recording.recorder);
    const auto state = [&] { return (*tracker)->camera_states().front(); };
    SourceRunner runner(**tracker);
    KeptFixes::Kept kept;
    runner.add_sink(std::make_unique<KeptFixes>(kept), Overflow::drop_oldest);
    runner.record_to(*recording.recorder);
    auto running = std::make_unique<Running>(runner);
    ASSERT_TRUE(wait_for([&] { return state().status == "away"; })) << state().status;
    EXPECT_NE(state().message.find("Connection refused"), std::string::npos) << state().message;
    ASSERT_TRUE(wait_for([&] {  // the page would hear of it
        const std::lock_guard lock(kept.mutex);
        return kept.batches > 0;
    }));
    for (int life = 0; life < 2; ++life) {
        Peer server({"/usr/bin/python3", ROOMFIX_SOURCE "/tests/connect/rtsp_server.py", std::to_string(port), "640", "480", "h264"});
        ASSERT_TRUE(server.wait_for_line());
        const FilmCamera camera(film, server);
        const std::size_t before = kept.found();
        ASSERT_TRUE(wait_for([&] { return kept.found() > before + 15; })) << kept.found() - before << ", " << state().status << ": " << state().message;
        EXPECT_EQ(state().bad_frames, 0);
        EXPECT_NE(state().note.find("times are"), std::string::npos) << state().note;
        server.kill();
        ASSERT_TRUE(wait_for([&] { return state().status == "away"; })) << state().status;
    }
    running.reset();
    ASSERT_TRUE(runner.finish_sinks());
    ASSERT_TRUE(recording.recorder->finish());
    expect_colours(recording.folder / "frames" / site.cameras[0].id);
    expect_same_fixes(kept.fixes, replayed(recording.folder, background));
    std::vector<double> errors;
    for (const Fix& fix : kept.fixes) {
        if (fix.status != FixStatus::ok) continue;
        const Pose2 truth = film.truth(fix.time);
        errors.push_back(std::hypot(fix.pose.x - truth.x, fix.pose.y - truth.y));
    }
    std::sort(errors.begin(), errors.end());
    ASSERT_FALSE(errors.empty());
    const double median = errors[errors.size() / 2];
    fmt::print("live: {} fixes, error median {:.1f} mm, largest {:.1f} mm; {}\n", errors.size(), 1e3 * median, 1e3 * errors.back(), state().note);
    EXPECT_LT(median, 0.03);
}

}  // namespace
}  // namespace roomfix
