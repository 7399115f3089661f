// What the program says while it runs: levels, times, priorities, and no secrets.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <regex>

#include "acceptance/program.hpp"
#include "roomfix/base/text_file.hpp"

namespace roomfix {
namespace {

namespace fs = std::filesystem;

class Log : public ::testing::Test {
protected:
    void SetUp() override {
        fs::create_directories(folder / "session/frames/hall");
        std::ofstream(folder / "session/site.yaml") << R"(roomfix: 1
site: {name: empty}
cameras:
  hall: {source: frames/hall, size: [64, 48], intrinsics: {fx: 60, fy: 60, cx: 31.5, cy: 23.5},
         pose: {position: [0, 0, 2], quaternion: [1, 0, 0, 0]}}
robots:
  r1: {shape: box, size: [0.5, 0.4, 0.3]}
)";
        std::ofstream(folder / "session/frames/hall/no-frames");
    }
    void TearDown() override { fs::remove_all(folder); }
    std::string replay() const { return fmt::format("replay {} --fixes /dev/null", (folder / "session").string()); }

    fs::path folder = fs::temp_directory_path() / fmt::format("roomfix_log_{}", getpid());
};

TEST_F(Log, HasTimesAndLevelsInAFileAndLeavesOutWhatIsBelow) {
    const Outcome all = call(replay());
    EXPECT_EQ(all.code, 0) << all.text;
    EXPECT_TRUE(std::regex_search(all.text, std::regex(R"(20\d\d-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{3}Z info: 0 fixes given\n)"))) << all.text;
    const Outcome warnings = call(replay() + " --log-level warning");
    EXPECT_EQ(warnings.text.find("info:"), std::string::npos) << warnings.text;
    const Outcome nothing_there = call("replay /nowhere --log-level error");
    expect_says(nothing_there, 2, "Z error: the session's site file cannot be used:");
    expect_says(call(replay() + " --log-level loud"), 2, "loud");
}

TEST_F(Log, HasPrioritiesInTheJournal) {
    const std::string file = (folder / "journal").string();
    std::ofstream{file};
    const std::string as_systemd =
        fmt::format("sh -c 'export JOURNAL_STREAM=$(stat -c %d:%i {0}); {1} {2} 2>{0}; {1} replay /nowhere 2>>{0}'", file, ROOMFIX_PROGRAM, replay());
    EXPECT_NE(std::system(as_systemd.c_str()), 0);
    const auto text = read_text(file);
    ASSERT_TRUE(text);
    EXPECT_NE(text->find("<6>0 fixes given\n"), std::string::npos) << *text;
    EXPECT_NE(text->find("<3>the session's site file cannot be used:\n<3>"), std::string::npos) << *text;
    EXPECT_EQ(text->find("Z info"), std::string::npos) << *text;
}

TEST_F(Log, TellsNoSecrets) {
    std::ofstream(folder / "site.yaml") << R"(roomfix: 1
site: {name: secrets}
cameras:
  hall: {source: "rtsp://operator:s3cret-1@127.0.0.1:1/stream?token=s3cret-2", size: [64, 48], intrinsics: {fx: 60, fy: 60, cx: 31.5, cy: 23.5},
         pose: {position: [0, 0, 2], quaternion: [1, 0, 0, 0]}}
robots:
  r1: {shape: box, size: [0.5, 0.4, 0.3]}
outputs:
  web: {port: 0, token: {env: ROOMFIX_TEST_TOKEN}}
)";
    const std::string log = (folder / "log").string();
    const std::string run = fmt::format(
        "ROOMFIX_TEST_TOKEN=s3cret-3-of-sixteen-or-more {} run {} --log-level debug 2>{} & pid=$!; "
        "for i in $(seq 600); do grep -q 'the map is at' {} && break; kill -0 $pid || break; sleep 0.1; done; kill -TERM $pid; wait $pid",
        ROOMFIX_PROGRAM, (folder / "site.yaml").string(), log, log);
    (void)std::system(run.c_str());
    const auto text = read_text(log);
    ASSERT_TRUE(text);
    EXPECT_NE(text->find("the map is at"), std::string::npos) << *text;
    EXPECT_NE(text->find("camera hall"), std::string::npos) << *text;
    EXPECT_EQ(text->find("s3cret"), std::string::npos) << *text;
}

}  // namespace
}  // namespace roomfix
