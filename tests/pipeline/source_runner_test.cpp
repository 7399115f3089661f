// A site at work on frames of one's own: overload, threads, latency.
#include "roomfix/pipeline/source_runner.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <thread>

#include "roomfix/base/steady_now.hpp"
#include "roomfix/evaluate/recorded_fixes.hpp"
#include "roomfix/pipeline/live_frames.hpp"
#include "roomfix/pipeline/recorded_frames.hpp"

namespace roomfix {
namespace {

/// Grey frames, `seconds` apart by their time stamps; a live one takes that long for each, a recorded one `reading` seconds.
class GreyFrames final : public FrameSource {
public:
    GreyFrames(int count, double seconds, bool live, Nanoseconds start, int width = 160, double reading = 0)
        : count_(count), seconds_(seconds), reading_(live ? seconds : reading), live_(live), start_(start), width_(width) {}
    Result<bool> advance(SourceFrame& frame) override {
        if (given_ == count_) return false;
        std::this_thread::sleep_for(std::chrono::duration<double>(reading_));
        frame.time = live_ ? system_now() : start_ + from_seconds(given_ * seconds_);
        ++given_;
        return true;
    }
    Result<void> decode(SourceFrame& frame) override {
        ++decoded_;
        frame.image.resize(width_, 120);
        for (int y = 0; y < 120; ++y) std::fill_n(frame.image.row(y), width_, static_cast<std::uint8_t>(100 + given_ % 7));
        return {};
    }
    int decoded() const { return decoded_; }
    bool live() const override { return live_; }
    std::int64_t count() const override { return count_; }

private:
    int count_;
    double seconds_, reading_;
    bool live_;
    Nanoseconds start_;
    int width_;
    int given_ = 0;
    int decoded_ = 0;
};

/// A hall with fixed cameras and one robot.
Site hall(int cameras) {
    Site site;
    for (int i = 0; i < cameras; ++i) {
        SiteCamera camera;
        camera.id = "hall" + std::to_string(i + 1);
        camera.model = make_camera_model(160, 120, 110, 110, 79.5, 59.5);
        KnownPose known;
        known.map_from_camera.pose = looking_at(Eigen::Vector3d(0.1, 0.5 * i, 2.5), {2, 2, 0});
        known.map_from_camera.covariance = 1e-6 * Matrix6d::Identity();
        camera.placement.emplace<KnownPose>(known);
        site.cameras.push_back(camera);
    }
    SiteRobot robot;
    robot.id = "r1";
    robot.shape = Box{0.5, 0.4, 0.4};
    site.robots.push_back(robot);
    return site;
}

LiveFrames::Listener never_fails(std::function<void(std::size_t)> ended) {
    const auto fail = [](std::size_t, const std::string& message) { FAIL() << message; };
    return {fail, fail, std::move(ended)};
}

/// Ten times more frames than can be looked at: what is looked at is fresh, and what is not is counted, and mostly not even decoded.
TEST(LiveFrames, TenTimesMoreThanCanBeTakenLeavesTheNewest) {
    GreyFrames source(400, 0.002, true, 0);
    std::atomic<bool> stop{false};
    FrameCount last;
    long used = 0;
    double oldest = 0;
    {
        LiveFrames frames({{3, &source}}, stop, never_fails([](std::size_t camera) { EXPECT_EQ(camera, 3U); }));
        for (auto round = frames.next_round(); !round.empty(); round = frames.next_round()) {
            ASSERT_EQ(round.size(), 1U);
            oldest = std::max(oldest, to_seconds(system_now() - round[0].frame.time));
            std::this_thread::sleep_for(std::chrono::milliseconds(20));
            last = round[0].count;
            ++used;
        }
    }
    EXPECT_GT(last.dropped, 200);
    EXPECT_LE(used + last.dropped, 400);
    EXPECT_LT(source.decoded(), 200);
    // A queue without an end would hand out frames that are more than half a second old.
    EXPECT_LT(oldest, 0.5);
}

/// Cameras that look at about the same time are looked at together.
TEST(LiveFrames, FramesOfAboutTheSameMomentComeTogether) {
    GreyFrames one(20, 0.05, true, 0), other(20, 0.05, true, 0);
    std::atomic<bool> stop{false};
    std::size_t together = 0, alone = 0;
    LiveFrames frames({{0, &one}, {1, &other}}, stop, never_fails([](std::size_t) {}));
    for (auto round = frames.next_round(); !round.empty(); round = frames.next_round()) {
        ++(round.size() == 2 ? together : alone);
        if (round.size() == 2) {
            EXPECT_LE(round[0].frame.time, round[1].frame.time);
        }
    }
    EXPECT_GT(together, alone);
}

/// A camera that is away for a while, and then gives a frame that is damaged, one that is whole, and no more until it is interrupted.
class Unsteady final : public FrameSource {
public:
    Result<bool> advance(SourceFrame&) override {
        if (++asked_ <= 2) return Error{"unplugged"};
        if (asked_ <= 4) {
            passed_over_ += 3;
            return true;
        }
        interrupted_.wait(false);
        return false;
    }
    Result<void> decode(SourceFrame& frame) override {
        if (asked_ == 3) return Error{"damaged"};
        frame.image.resize(8, 8);
        return {};
    }
    bool live() const override { return true; }
    std::int64_t count() const override { return -1; }
    std::string note() const override { return "its clock is right"; }
    std::int64_t passed_over() const override { return passed_over_; }
    void interrupt() override {
        interrupted_ = true;
        interrupted_.notify_all();
    }

private:
    int asked_ = 0;
    std::int64_t passed_over_ = 0;
    std::atomic<bool> interrupted_{false};
};

TEST(LiveFrames, ACameraThatComesBackGoesOnAndSaysSoMeanwhile) {
    Unsteady source;
    std::atomic<bool> stop{false};
    std::vector<std::string> told;
    {
        LiveFrames frames({{0, &source}}, stop,
                          {[&](std::size_t, const std::string& message) { told.push_back("failed: " + message); },
                           [&](std::size_t, const std::string& message) { told.push_back("away: " + message); }, [](std::size_t) { FAIL(); }});
        const auto round = frames.next_round();
        ASSERT_EQ(round.size(), 1U);
        EXPECT_EQ(round[0].note, "its clock is right");
        EXPECT_EQ(round[0].count.came, 8);  // one damaged, one whole, and three before each
        EXPECT_EQ(round[0].count.dropped, 6);
        stop = true;
    }
    EXPECT_EQ(told, (std::vector<std::string>{"away: unplugged", "away: unplugged", "failed: damaged"}));
}

/// A recording that is run by the clock, far faster than it can be read: frames are dropped, and the runner says so.
TEST(SourceRunner, SaysSoWhereItCannotKeepUp) {
    auto tracker = SiteTracker::create(hall(1));
    ASSERT_TRUE(tracker) << tracker.error().message;
    std::vector<std::unique_ptr<FrameSource>> sources;
    sources.push_back(std::make_unique<GreyFrames>(800, 0.1, false, 1'000'000'000, 160, 0.001));
    std::atomic<bool> stop{false};
    RunSettings settings;
    settings.speed = 1e6;
    settings.on_time = true;
    ASSERT_TRUE(SourceRunner(**tracker).run(std::move(sources), settings, stop));
    const CameraState state = (*tracker)->camera_states().front();
    EXPECT_GT(state.dropped, 0);
    EXPECT_EQ(state.frames + state.dropped, 800);
}

TEST(SourceRunner, DropsNothingOfARecordingThatIsRunWithoutAClock) {
    for (const double speed : {0.0, 1e5}) {
        auto tracker = SiteTracker::create(hall(1));
        ASSERT_TRUE(tracker);
        std::vector<std::unique_ptr<FrameSource>> sources;
        sources.push_back(std::make_unique<GreyFrames>(500, 0.1, false, 1'000'000'000));
        std::atomic<bool> stop{false};
        RunSettings settings;
        settings.speed = speed;
        ASSERT_TRUE(SourceRunner(**tracker).run(std::move(sources), settings, stop));
        EXPECT_EQ((*tracker)->camera_states().front().frames, 500);
        EXPECT_EQ((*tracker)->camera_states().front().dropped, 0);
    }
}

TEST(SourceRunner, FramesOfAWrongSizeAreRefusedWithTheCure) {
    auto tracker = SiteTracker::create(hall(2));
    ASSERT_TRUE(tracker);
    std::vector<std::unique_ptr<FrameSource>> sources;
    sources.push_back(std::make_unique<GreyFrames>(5, 0.1, false, 1'000'000'000, 200));
    sources.push_back(std::make_unique<GreyFrames>(5, 0.1, false, 1'000'000'000));
    std::atomic<bool> stop{false};
    const auto done = SourceRunner(**tracker).run(std::move(sources), {0, false, 2}, stop);
    ASSERT_FALSE(done);
    EXPECT_NE(done.error().message.find("camera hall1: the frame is 200 x 120 pixels, the site file says 160 x 120"), std::string::npos);
}

TEST(RecordedFrames, RoundsHoldDifferentCamerasOfAboutTheSameTime) {
    std::vector<std::unique_ptr<FrameSource>> sources;
    sources.push_back(std::make_unique<GreyFrames>(3, 0.1, false, 0));
    sources.push_back(std::make_unique<GreyFrames>(3, 0.1, false, 30'000'000));
    sources.push_back(std::make_unique<GreyFrames>(3, 0.1, false, 60'000'000));
    std::atomic<bool> stop{false};
    int ended = 0;
    RecordedFrames frames(sources, stop, {[](std::size_t, const std::string&) { FAIL(); }, [&](std::size_t) { ++ended; }, {}, {}});
    EXPECT_EQ(frames.total(), 9);
    std::vector<std::vector<std::size_t>> rounds;
    for (auto round = frames.next_round(); !round.empty(); round = frames.next_round()) {
        rounds.push_back(round);
        for (const std::size_t camera : round) {
            (void)frames.take(camera);
            frames.advance(camera);
        }
    }
    const std::vector<std::vector<std::size_t>> expected = {{0, 1}, {2, 0}, {1, 2}, {0, 1}, {2}};
    EXPECT_EQ(rounds, expected);
    EXPECT_EQ(ended, 3);
}

}  // namespace
}  // namespace roomfix
