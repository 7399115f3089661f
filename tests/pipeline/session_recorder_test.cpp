// Recordings: their parts, what is lost where the disk takes nothing, and what a recording needs of the site.
#include "roomfix/pipeline/session_recorder.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <thread>

#include "roomfix/base/text_file.hpp"
#include "roomfix/pipeline/session_content.hpp"
#include "roomfix/site/load_site.hpp"
#include "temporary_folder.hpp"

namespace roomfix {
namespace {

namespace fs = std::filesystem;

class Recording : public TemporaryFolder {};

constexpr const char* recorded_site = R"(roomfix: 1
site: {name: "lab: two", lost: 0.9}   # a comment that stays
cameras:
  hall: {source: rtsp://camera/1, size: [160, 120], intrinsics: {fx: 110, fy: 110, cx: 79.5, cy: 59.5}, background: empty,
         pose: {position: [0.1, 0, 2.5], quaternion: [1, 0, 0, 0]}}
robots:
  r1:
    shape: box
    size: [0.5, 0.4, 0.4]
    odometry: {source: wheels.csv}
    receiver: {position: [0, 0, 0.1], source: /dev/ttyUSB0}
beacons:
  n1: {position: [1, 1, 3]}
outputs:
  mqtt: {host: broker}
  history: {database: fixes.db}
)";

SessionContent one_camera() {
    SessionContent content;
    content.site_yaml = "roomfix: 1\n";
    content.cameras = {"hall"};
    return content;
}

/// A frame of a few hundred bytes.
SourceFrame small_frame(Nanoseconds time) {
    SourceFrame frame;
    frame.time = time;
    frame.file = [] { return PictureFile{std::vector<std::uint8_t>(500, 7), "jpg"}; };
    return frame;
}

long frames_in(const fs::path& session) {
    std::error_code failure;
    return std::distance(fs::directory_iterator(session / "frames/hall", failure), {});
}

std::vector<std::string> names_in(const fs::path& folder) {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder)) names.push_back(entry.path().filename().string());
    std::sort(names.begin(), names.end());
    return names;
}

TEST_F(Recording, TheSessionsSiteFileSpeaksOfTheSessionAndKeepsTheRest) {
    std::ofstream(folder / "site.yaml") << recorded_site;
    fs::create_directories(folder / "empty");
    std::ofstream(folder / "empty/1.png") << "background";
    const auto site = load_site(folder / "site.yaml");
    ASSERT_TRUE(site) << site.error().message;
    const auto tracker = SiteTracker::create(*site);
    ASSERT_TRUE(tracker) << tracker.error().message;
    auto content = session_content(**tracker, folder / "site.yaml", {});
    ASSERT_TRUE(content) << content.error().message;
    EXPECT_NE(content->site_yaml.find("# a comment that stays"), std::string::npos) << content->site_yaml;
    auto recorder = SessionRecorder::start({folder / "session"}, *content);
    ASSERT_TRUE(recorder) << recorder.error().message;
    const auto finished = (*recorder)->finish();
    ASSERT_TRUE(finished) << finished.error().message;

    const auto recorded = load_session(folder / "session");
    ASSERT_TRUE(recorded) << recorded.error().message;
    EXPECT_EQ(recorded->name, "lab: two");
    EXPECT_EQ(recorded->lost, 0.9);
    EXPECT_EQ(recorded->cameras[0].source, "frames/hall");
    EXPECT_EQ(recorded->cameras[0].background, "background/hall");
    EXPECT_EQ(*read_text(folder / "session/background/hall/1.png"), "background");
    EXPECT_EQ(recorded->robots[0].odometry->source, "odometry.csv");
    EXPECT_EQ(recorded->robots[0].receivers[0].source, "ranges.csv");
    EXPECT_FALSE(recorded->outputs.mqtt || recorded->outputs.history) << "a replay publishes nothing";
    EXPECT_EQ(names_in(folder / "session"),
              (std::vector<std::string>{"background", "fixes.jsonl", "frames", "odometry.csv", "ranges.csv", "sightings.csv", "site.yaml"}));
    const auto source = open_source((folder / "session/frames/hall").string());
    ASSERT_TRUE(source) << "a camera that gave no frame is no mistake: " << source.error().message;
    SourceFrame frame;
    const auto more = (*source)->next(frame);
    EXPECT_TRUE(more && !*more);
}

TEST_F(Recording, AFolderThatHoldsSomethingIsRefused) {
    std::ofstream(folder / "thesis.txt") << "years of work";
    const auto refused = SessionRecorder::start({folder}, one_camera());
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message.find("is not empty, and nothing in it is overwritten: choose a new folder"), std::string::npos);
    const auto file = SessionRecorder::start({folder / "thesis.txt"}, one_camera());
    ASSERT_FALSE(file);
    EXPECT_NE(file.error().message.find("is a file"), std::string::npos);
}

TEST_F(Recording, BeyondItsSizeTheOldestPartsGoAndTheOthersAreWhole) {
    SessionContent content = one_camera();
    std::ofstream(folder / "background.png") << std::string(1000, 'b');
    content.files = {{folder / "background.png", "background/hall.png"}};
    RecorderSettings settings{.folder = folder / "record", .limits = {.gigabytes = 1e-4}, .wait = true};  // 100 kB
    auto recorder = SessionRecorder::start(settings, content);
    ASSERT_TRUE(recorder);
    for (int i = 0; i < 1000; ++i) (*recorder)->give(0, small_frame(i));
    ASSERT_TRUE((*recorder)->finish());
    EXPECT_EQ((*recorder)->state().frames, 1000);
    EXPECT_EQ((*recorder)->state().lost, 0);
    const auto parts = names_in(folder / "record");
    EXPECT_GE(parts.size(), 8U);
    EXPECT_LE(parts.size(), 11U);
    EXPECT_GT(parts.front(), "part-0020");
    std::uintmax_t bytes = 0;
    for (const auto& entry : fs::recursive_directory_iterator(folder / "record")) bytes += entry.is_regular_file() ? entry.file_size() : 0;
    EXPECT_LE(bytes, 100'000U);
    EXPECT_GE(bytes, 80'000U);
    long next = -1;
    for (const std::string& part : parts) {
        for (const char* file : {"site.yaml", "ranges.csv", "background/hall.png", "fixes.jsonl"})
            EXPECT_TRUE(fs::exists(folder / "record" / part / file)) << part;
        EXPECT_FALSE(fs::exists(folder / "record" / part / "unfinished"));
        for (const std::string& name : names_in(folder / "record" / part / "frames/hall")) {
            const long time = std::stol(name);
            if (next >= 0) {
                ASSERT_EQ(time, next) << "parts follow each other without a gap";
            }
            next = time + 1;
        }
    }
    EXPECT_EQ(next, 1000);
}

TEST_F(Recording, ByItsAgeTheRecordingGoesOnInPartsAndTheOldestGo) {
    RecorderSettings settings{.folder = folder / "record", .limits = {.minutes = 0.2 / 60}, .wait = true};  // however slow the disk
    auto recorder = SessionRecorder::start(settings, one_camera());
    ASSERT_TRUE(recorder);
    int time = 0;
    while (!fs::exists(folder / "record/part-0015/site.yaml") || fs::exists(folder / "record/part-0001")) {
        (*recorder)->give(0, small_frame(++time));
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
        ASSERT_LT(time, 30000);
    }
    const auto finished = (*recorder)->finish();
    ASSERT_TRUE(finished) << finished.error().message;
}

TEST_F(Recording, WhileTheFolderIsGoneTheRunGoesOnAndTheRecordingComesBack) {
    std::ofstream(folder / "disk") << "a file where the folder should be";
    std::atomic<int> told = 0;
    RecorderSettings settings{.folder = folder / "disk/record", .on_trouble = [&](const std::string&) { ++told; }};
    auto recorder = SessionRecorder::start(settings, one_camera());
    ASSERT_TRUE(recorder) << recorder.error().message;
    int time = 0;
    const auto give_until = [&](const std::function<bool()>& condition) {
        while (!condition() && time < 30000) {
            (*recorder)->give(0, small_frame(++time));
            std::this_thread::sleep_for(std::chrono::milliseconds(2));
        }
        ASSERT_TRUE(condition());
    };
    give_until([&] { return (*recorder)->state().lost > 0; });
    EXPECT_FALSE((*recorder)->state().ok);
    EXPECT_EQ(told, 1);
    fs::remove(folder / "disk");
    give_until([&] { return (*recorder)->state().ok; });
    EXPECT_EQ(told, 2);
    const auto finished = (*recorder)->finish();
    ASSERT_FALSE(finished) << "something is missing in the recording";
    EXPECT_NE(finished.error().message.find("frames, readings and fixes are missing in the recording"), std::string::npos) << finished.error().message;
    const RecordingState state = (*recorder)->state();
    EXPECT_EQ(state.frames + state.lost, time);
    EXPECT_EQ(frames_in(folder / "disk/record"), state.frames);
}

/// A disk that stands still.
TEST_F(Recording, WhoGivesFramesNeverWaitsForTheDisk) {
    std::atomic<bool> stands_still = true;
    auto recorder = SessionRecorder::start({folder / "record"}, one_camera());
    ASSERT_TRUE(recorder);
    for (int i = 1; i <= 500; ++i) {
        SourceFrame frame = small_frame(i);
        frame.file = [&] {
            while (stands_still) std::this_thread::sleep_for(std::chrono::milliseconds(1));
            return PictureFile{{1, 2, 3}, "jpg"};
        };
        (*recorder)->give(0, std::move(frame));
    }
    EXPECT_GE((*recorder)->state().lost, 450) << "of 500 some wait, in bounded memory";
    EXPECT_FALSE((*recorder)->state().ok);
    stands_still = false;
    EXPECT_FALSE((*recorder)->finish());
    EXPECT_EQ((*recorder)->state().frames + (*recorder)->state().lost, 500);
}

TEST_F(Recording, AFrameWithoutItsFileIsRecordedAsItsGreyPicture) {
    auto recorder = SessionRecorder::start({folder / "record"}, one_camera());
    SourceFrame frame;
    frame.time = 5;
    frame.image.resize(40, 30);
    for (int y = 0; y < 30; ++y) std::fill_n(frame.image.row(y), 40, static_cast<std::uint8_t>(y));
    (*recorder)->give(0, std::move(frame));
    ASSERT_TRUE((*recorder)->finish());
    auto source = open_source((folder / "record/frames/hall").string());
    ASSERT_TRUE(source);
    SourceFrame read;
    const auto more = (*source)->next(read);
    ASSERT_TRUE(more && *more);
    EXPECT_EQ(read.time, 5);
    EXPECT_EQ(read.image.row(17)[3], 17);
}

}  // namespace
}  // namespace roomfix
