// `run --record`: the same fixes again, kill -9, full disks.
#include <fcntl.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "acceptance/program.hpp"
#include "roomfix/base/text_file.hpp"
#include "roomfix/evaluate/recorded_fixes.hpp"
#include "temporary_folder.hpp"

namespace roomfix {
namespace {

namespace fs = std::filesystem;

class Record : public TemporaryFolder {
protected:
    std::string path(const std::string& name) const { return (folder / name).string(); }
    void simulate(const std::string& scenario, double seconds) const {
        const Outcome made = call(fmt::format("simulate {} --duration {} -o {}", scenario, seconds, path("session")));
        ASSERT_EQ(made.code, 0) << made.text;
        keep_little_background();
    }
    /// To learn from all of it would take longer than everything else.
    void keep_little_background() const {
        std::error_code none;
        for (const auto& camera : fs::directory_iterator(path("session") + "/background", none)) {
            for (const auto& frame : fs::directory_iterator(camera)) {
                if (frame.path().stem().string() > "000200000000") fs::remove(frame);
            }
        }
    }
    /// As of a camera whose clock is heard only from the third picture on.
    void let_times_be_unsure() const {
        for (const auto& camera : fs::directory_iterator(path("session") + "/frames")) {
            std::vector<std::string> times;
            for (const auto& frame : fs::directory_iterator(camera)) times.push_back(std::to_string(std::stoll(frame.path().stem().string())));
            std::sort(times.begin(), times.end(), [](const std::string& a, const std::string& b) { return std::stoll(a) < std::stoll(b); });
            std::ofstream(camera.path() / "time-errors.csv") << "nanoseconds,sigma,way\n" << times.at(0) << ",0.05,1\n" << times.at(2) << ",0.003,0\n";
        }
    }
};

/// The program in a process of its own, which may be killed.
class RunningProgram {
public:
    explicit RunningProgram(const std::string& arguments) {
        process_ = fork();
        if (process_ != 0) return;
        const std::string command = "exec " + std::string(ROOMFIX_PROGRAM) + " " + arguments + " >/dev/null 2>&1";
        execl("/bin/sh", "sh", "-c", command.c_str(), nullptr);
        _exit(127);
    }
    ~RunningProgram() { kill(); }
    RunningProgram(const RunningProgram&) = delete;
    RunningProgram& operator=(const RunningProgram&) = delete;
    void kill() {
        if (process_ <= 0) return;
        ::kill(process_, SIGKILL);
        waitpid(process_, nullptr, 0);
        process_ = -1;
    }

private:
    pid_t process_ = -1;
};

TEST_F(Record, ReplayOfARecordingGivesTheSameBytes) {
    // A fixed camera with its background; and a camera on the robot, ranges and wheels.
    for (const auto& [scenario, seconds] : {std::pair{"li2014", 0.5}, std::pair{"kim2011-drive", 1.5}}) {
        SCOPED_TRACE(scenario);
        simulate(scenario, seconds);
        let_times_be_unsure();
        const std::string record = fmt::format("run {}/site.yaml --no-page --speed 0 --fixes {} --record {}", path("session"), path("ran.jsonl"), path("same"));
        expect_says(call(record), 0, "recorded to");
        const Outcome replayed = call(fmt::format("replay {} --fixes {}", path("same"), path("replayed.jsonl")));
        ASSERT_EQ(replayed.code, 0) << replayed.text;
        const std::string fixes = *read_text(path("ran.jsonl"));
        EXPECT_GT(std::count(fixes.begin(), fixes.end(), '\n'), 3);
        EXPECT_EQ(fixes, *read_text(path("replayed.jsonl")));
        EXPECT_EQ(fixes, *read_text(path("same") + "/fixes.jsonl"));
        for (const auto& entry : fs::recursive_directory_iterator(path("session") + "/frames")) {
            if (!entry.is_regular_file()) continue;
            EXPECT_EQ(*read_text(entry.path()), *read_text(path("same") / fs::relative(entry.path(), path("session")))) << "as it came";
        }
        expect_says(call(record), 2, "is not empty");
        fs::remove_all(path("session"));
        fs::remove_all(path("same"));
    }
}

class KilledRecord : public Record {
protected:
    std::string session_of(int program) const { return path(fmt::format("killed{}", program)); }
    std::string fixes_of(int program) const { return path(fmt::format("{}.jsonl", program)); }
    std::unique_ptr<RunningProgram> start(int program) const {
        fs::remove_all(session_of(program));
        fs::remove(fixes_of(program));
        return std::make_unique<RunningProgram>(
            fmt::format("run {}/site.yaml --no-page --speed 1 --fixes {} --record {}", path("session"), fixes_of(program), session_of(program)));
    }
    bool has_fixes(int program) const { return fs::exists(session_of(program) + "/site.yaml") && load_fixes(fixes_of(program)); }
    /// Each some time after its own first fix, and long before its session ends.
    bool kill_each(std::vector<std::unique_ptr<RunningProgram>>& running) {
        using Clock = std::chrono::steady_clock;
        std::uniform_int_distribution<int> wait(100000, 700000);
        std::vector<std::optional<Clock::time_point>> due(running.size());
        for (std::size_t alive = running.size(), tries = 0; alive > 0; ++tries) {
            if (tries == 60000) return false;
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
            for (std::size_t i = 0; i < running.size(); ++i) {
                if (!running[i]) continue;
                if (!due[i] && has_fixes(static_cast<int>(i))) due[i] = Clock::now() + std::chrono::microseconds(wait(random_));
                if (!due[i] || Clock::now() < *due[i]) continue;
                running[i].reset();
                --alive;
            }
        }
        return true;
    }
    /// What the program had in its hands is known from the fixes that it wrote at once.
    void expect_whole(int program) const {
        EXPECT_TRUE(fs::exists(session_of(program) + "/unfinished"));
        const auto given = load_fixes(fixes_of(program));
        ASSERT_TRUE(given) << given.error().message;
        const auto seconds_lost = [&](const std::string& file) {
            const auto text = read_text(file);
            if (!text) return 1e9;
            const RecordedFixes left = parse_fixes(*text);  // none: it was killed before it had written any
            EXPECT_TRUE(left.problems.empty()) << left.problems.front();
            return to_seconds(given->fixes.back().time - (left.fixes.empty() ? given->fixes.front() : left.fixes.back()).time);
        };
        EXPECT_LT(seconds_lost(session_of(program) + "/fixes.jsonl"), 1);
        const Outcome replayed = call(fmt::format("replay {} --fixes {}", session_of(program), path("again.jsonl")));
        ASSERT_EQ(replayed.code, 0) << replayed.text;
        EXPECT_LT(seconds_lost(path("again.jsonl")), 1);
    }

private:
    std::mt19937 random_{std::random_device{}()};
};

/// ROOMFIX_KILLS in the environment: how many are killed (default 4).
TEST_F(KilledRecord, AtAnyMomentItLeavesASessionThatLacksLessThanASecond) {
    simulate("kim2011-drive", 3);
    constexpr int programs = 4;  // at a time
    const char* asked = std::getenv("ROOMFIX_KILLS");
    const int kills = asked ? std::max(std::atoi(asked), programs) : programs;
    for (int killed = 0; killed < kills; killed += programs) {
        std::vector<std::unique_ptr<RunningProgram>> running;
        for (int i = 0; i < programs; ++i) running.push_back(start(i));
        ASSERT_TRUE(kill_each(running));
        for (int i = 0; i < programs; ++i) {
            SCOPED_TRACE(killed + i);
            expect_whole(i);
        }
    }
}

/// No file may be larger than 4 kB.
TEST_F(Record, WhereFilesCannotGrowTheRunGoesOnAndEndsWithAnError) {
    simulate("kim2011-drive", 1);
    const std::string command = fmt::format("sh -c \"trap '' XFSZ; ulimit -f 8; exec {} run {}/site.yaml --no-page --speed 0 --record {}\" 2>&1",
                                            ROOMFIX_PROGRAM, path("session"), path("small"));
    FILE* pipe = popen(command.c_str(), "r");
    std::string text(1 << 16, '\0');
    text.resize(std::fread(text.data(), 1, text.size(), pipe));
    EXPECT_EQ(WEXITSTATUS(pclose(pipe)), 1) << text;
    EXPECT_NE(text.find("not recorded: "), std::string::npos) << text;
    EXPECT_NE(text.find("make room there"), std::string::npos) << text;
    EXPECT_NE(text.find("are missing in the recording"), std::string::npos) << text;
    EXPECT_NE(text.find("camera up: 10 frames"), std::string::npos) << "the run itself is whole: " << text;
}

TEST_F(Record, AFullOrReadOnlyDiskIsSaidAndWhatFitsCanBeReplayed) {
    simulate("kim2011-drive", 3);
    fs::create_directories(path("disk"));
    const auto with_disk = [this](const std::string& options, const std::string& commands) {
        return fmt::format("unshare -rm sh -c 'mount -t tmpfs -o {} disk {}; {}' 2>&1", options, path("disk"), commands);
    };
    if (std::system((with_disk("size=1m", "true") + " >/dev/null").c_str()) != 0) GTEST_SKIP() << "no file systems of one's own here";
    const auto output_of = [](const std::string& command) {
        FILE* pipe = popen(command.c_str(), "r");
        std::string text(1 << 16, '\0');
        text.resize(std::fread(text.data(), 1, text.size(), pipe));
        pclose(pipe);
        return text;
    };
    const std::string run = fmt::format("{} run {}/site.yaml --no-page --speed 0 --fixes {} --record {}/rec; echo code $?", ROOMFIX_PROGRAM, path("session"),
                                        path("whole.jsonl"), path("disk"));
    const std::string replay = fmt::format("{} replay {}/rec --fixes {}; echo replay $?", ROOMFIX_PROGRAM, path("disk"), path("part.jsonl"));
    const std::string full = output_of(with_disk("size=300k", run + "; " + replay));
    EXPECT_NE(full.find("No space left on device): make room there"), std::string::npos) << full;
    EXPECT_NE(full.find("code 1"), std::string::npos) << full;
    EXPECT_NE(full.find("replay 0"), std::string::npos) << full;
    const auto whole = load_fixes(path("whole.jsonl"));
    ASSERT_TRUE(whole);
    EXPECT_GT(whole->fixes.back().time, from_seconds(2.9)) << "the run went on to its end";
    const std::string read_only = output_of(with_disk("ro", run));
    EXPECT_NE(read_only.find("Read-only file system"), std::string::npos) << read_only;
    EXPECT_NE(read_only.find("code 1"), std::string::npos) << read_only;

    // What does not fit is counted: with what was written it is all that a disk with room gets.
    const auto number_after = [](const std::string& text, std::size_t at) { return at == std::string::npos ? -1 : std::atol(text.c_str() + at + 1); };
    const auto last_number = [&](const std::string& text) { return number_after(text, text.rfind('\n', text.size() - 2)); };
    const std::string drive = fmt::format("{} run {}/examples/labyrinth/site.yaml --no-page --speed 0 --record {}/rec; cat {}/rec/*.csv {}/rec/*.jsonl | wc -l",
                                          ROOMFIX_PROGRAM, ROOMFIX_SOURCE, path("disk"), path("disk"), path("disk"));
    const std::string all = output_of(with_disk("size=9m", drive)), some = output_of(with_disk("size=100k", drive));
    EXPECT_GT(last_number(some), 0) << some;
    EXPECT_EQ(last_number(some) + number_after(some, some.find("; ")), last_number(all)) << some << all;
}

}  // namespace
}  // namespace roomfix
