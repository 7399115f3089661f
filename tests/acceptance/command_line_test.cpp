// The program as its users call it.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <sstream>

#include "acceptance/data_folder.hpp"
#include "acceptance/program.hpp"
#include "roomfix/imaging/load_luma.hpp"

namespace roomfix {
namespace {

namespace fs = std::filesystem;

/// One short session for all tests.
class CommandLine : public ::testing::Test {
protected:
    static void SetUpTestSuite() {
        folder = new fs::path(fs::temp_directory_path() / fmt::format("roomfix_command_line_{}", getpid()));
        fs::remove_all(*folder);
        const Outcome made = call(fmt::format("simulate li2014 --duration 1.2 -o {}", session()));
        ASSERT_EQ(made.code, 0) << made.text;
    }
    static void TearDownTestSuite() {
        fs::remove_all(*folder);
        delete folder;
    }
    static std::string session() { return (*folder / "session").string(); }
    static std::string site() { return session() + "/site.yaml"; }
    static std::string frame() { return session() + "/frames/hall1/000500000000.jpg"; }
    static fs::path* folder;
};
fs::path* CommandLine::folder = nullptr;

TEST_F(CommandLine, CheckAcceptsTheSessionAndListsAllMistakes) {
    expect_says(call("check " + site()), 0, "ready");
    const std::string broken = (*folder / "broken.yaml").string();
    std::ofstream(broken) << "roomfix: 1\nsite: {nam: x}\nrobots:\n  r1: {shape: ball, size: [1, 1, 1]}\n";
    const Outcome outcome = call("check " + broken);
    expect_says(outcome, 2, "broken.yaml:2:8: error: site has no key 'nam': did you mean 'name'?");
    expect_says(outcome, 2, "broken.yaml:4:15: error: robots.r1.shape must be box or cylinder");
    expect_says(call("check /nowhere.yaml"), 2, "cannot be read");
}

TEST_F(CommandLine, FixFindsTheRobot) {
    const Outcome outcome = call(fmt::format("fix {} --camera hall1 {}", site(), frame()));
    expect_says(outcome, 0, "\"status\": \"ok\"");
    expect_says(outcome, 0, "\"robot\": \"r1\"");
    expect_says(outcome, 0, "\"hypotheses\"");
    const Outcome published = call(fmt::format("fix {} --camera hall1 --method published {}", site(), frame()));
    expect_says(published, 0, "\"yaw\": null");
}

TEST_F(CommandLine, AnOptionTakesOneValueAndLeavesWhatStandsBehindItAlone) {
    const std::string empty = session() + "/background/hall1", other = session() + "/frames/hall1/000600000000.jpg";
    const Outcome both = call(fmt::format("fix {} --camera hall1 --background {} {} {}", site(), empty, frame(), other));
    for (const std::string& picture : {frame(), other}) expect_says(both, 0, "\"image\": \"" + picture);
    const Outcome twice = call(fmt::format("fix --background {} --background {} --camera hall1 {} {}", empty, empty, site(), frame()));
    expect_says(twice, 0, "\"image\": \"" + frame());
    expect_says(call(fmt::format("run --background /nowhere.mp4 {} --no-page --speed 0", site())), 2, "/nowhere.mp4");
    expect_says(call(fmt::format("replay --background /nowhere.mp4 {} --threads 1", session())), 2, "/nowhere.mp4");
    expect_says(call(fmt::format("calibrate site --camera atlantis {} --threads 1", session())), 2, "there is no camera 'atlantis'");
}

TEST_F(CommandLine, FixSaysWhatIsWrongWithItsInput) {
    expect_says(call(fmt::format("fix {} --camera attic {}", site(), frame())), 2, "there is no camera 'attic'");
    expect_says(call(fmt::format("fix {} --camera hall1 /nowhere.jpg", site())), 2, "/nowhere.jpg: cannot be opened");
    expect_says(call(fmt::format("fix {} --camera hall3 {}", site(), frame())), 2, "480 x 360");
    const std::string cut = (*folder / "cut.jpg").string();
    fs::copy_file(frame(), cut);
    fs::resize_file(cut, fs::file_size(cut) / 2);
    const Outcome truncated = call(fmt::format("fix {} --camera hall1 {} {}", site(), cut, frame()));
    expect_says(truncated, 2, "truncated JPEG");
    expect_says(truncated, 2, "\"status\": \"ok\"");  // the good picture beside it is not lost
    const std::string empty = (*folder / "empty.png").string();
    fs::copy_file(session() + "/background/hall1/000000000000.jpg", *folder / "empty.jpg");
    expect_says(call(fmt::format("fix {} --camera hall1 {}", site(), (*folder / "empty.jpg").string())), 0, "nothing differs from the background");
    expect_says(call("fix"), 2, "required");
    expect_says(call("fixx"), 2, "");
}

TEST_F(CommandLine, RunGoesThroughRecordingsAndEnds) {
    const std::string fixes = (*folder / "fixes.jsonl").string();
    const Outcome first = call(fmt::format("run {} --no-page --speed 0 --fixes {}", site(), fixes));
    expect_says(first, 0, "fixes given");
    std::ifstream file(fixes);
    int lines = 0;
    for (std::string line; std::getline(file, line);) lines += line.find("\"robot\": \"r1\"") != std::string::npos;
    EXPECT_GE(lines, 10) << first.text;
    // Same input, same bytes.
    const std::string again = (*folder / "again.jsonl").string();
    call(fmt::format("run {} --no-page --speed 0 --fixes {}", site(), again));
    std::ifstream a(fixes), b(again);
    EXPECT_EQ(std::string(std::istreambuf_iterator<char>(a), {}), std::string(std::istreambuf_iterator<char>(b), {}));
}

TEST_F(CommandLine, RunSaysWhatIsMissing) {
    fs::create_directories(*folder / "bare");
    fs::copy_file(site(), *folder / "bare/site.yaml", fs::copy_options::overwrite_existing);
    expect_says(call(fmt::format("run {} --no-page --speed 0", (*folder / "bare/site.yaml").string())), 2, "does not exist");
    fs::create_directories(*folder / "bare/background/hall1");
    expect_says(call(fmt::format("run {} --no-page --speed 0", (*folder / "bare/site.yaml").string())), 2, "no picture in this folder");
    expect_says(call("run /nowhere.yaml"), 2, "cannot be used");
}

/// A robot with a camera that looks up, for all tests of it.
class Onboard : public ::testing::Test {
protected:
    static void SetUpTestSuite() {
        folder = new fs::path(fs::temp_directory_path() / fmt::format("roomfix_onboard_{}", getpid()));
        fs::remove_all(*folder);
        fs::create_directories(*folder);
        ASSERT_EQ(call(fmt::format("simulate kim2011 --duration 2 -o {}", (*folder / "room").string())).code, 0);
    }
    static void TearDownTestSuite() {
        fs::remove_all(*folder);
        delete folder;
    }
    static std::string site() { return (*folder / "room/site.yaml").string(); }
    static std::string frame() { return (*folder / "room/frames/up/000500000000.jpg").string(); }
    static std::string ranges() { return (*folder / "room/ranges.csv").string(); }
    static fs::path* folder;
};
fs::path* Onboard::folder = nullptr;

TEST_F(Onboard, FixUsesTheLandmarkAndTheRanges) {
    expect_says(call(fmt::format("fix {} --camera up {}", site(), frame())), 0, "\"sources\": [\"up\"]");
    const std::string overlay = (*folder / "overlay").string();
    const Outcome both = call(fmt::format("fix {} --camera up --ranges {} --overlay {} {}", site(), ranges(), overlay, frame()));
    expect_says(both, 0, "\"sources\": [\"up\", \"ranges\"]");
    EXPECT_TRUE(fs::exists(fs::path(overlay) / "000500000000.png"));
    expect_says(call(fmt::format("fix {} --camera up --landmark n1 --method published --ranges {} {}", site(), ranges(), frame())), 0, "\"status\": \"ok\"");
    const std::string dark = (*folder / "dark.png").string();
    ASSERT_TRUE(save_luma(dark, LumaImage(352, 288)));
    expect_says(call(fmt::format("fix {} --camera up {}", site(), dark)), 0, "no small bright spot");
    expect_says(call(fmt::format("fix {} --camera up --ranges {} {}", site(), ranges(), dark)), 0, "\"yaw\": null");
}

TEST_F(Onboard, FixSaysWhatIsWrong) {
    expect_says(call(fmt::format("fix {} --camera up --landmark n9 {}", site(), frame())), 2, "no such landmark");
    expect_says(call(fmt::format("fix {} --camera up --ranges /nowhere.csv {}", site(), frame())), 2, "/nowhere.csv: no ranges can be read");
    const std::string bad = (*folder / "bad.csv").string();
    std::ofstream(bad) << "time,robot,beacon,range\n0.5,r1,n9,2.8\n0.5,r1,n1,-2.8\n0.5,r1,n1,2.76\n";
    const Outcome outcome = call(fmt::format("fix {} --camera up --ranges {} {}", site(), bad, frame()));
    expect_says(outcome, 0, "unknown beacon 'n9'");
    expect_says(outcome, 0, "cannot be");
    expect_says(outcome, 0, "\"status\": \"ok\"");
}

TEST_F(Onboard, RunFollowsTheRobot) {
    const Outcome outcome = call(fmt::format("run {} --no-page --speed 0 --fixes -", site()));
    expect_says(outcome, 0, "\"robot\": \"r1\", \"status\": \"ok\"");
    expect_says(outcome, 0, "fixes given");
}

TEST_F(Onboard, CalibrateMountMeasuresTheTiltAndWritesIt) {
    const std::string spin = (*folder / "spin").string();
    ASSERT_EQ(call(fmt::format("simulate kim2011-spin -o {}", spin)).code, 0);
    const std::string file = spin + "/site.yaml";
    expect_says(call(fmt::format("calibrate mount {} --camera up", file)), 0, "not written");
    const Outcome written = call(fmt::format("calibrate mount {} --camera up --write", file));
    expect_says(written, 0, "tilt 0.");
    expect_says(written, 0, "the file as it was is");
    expect_says(call("check " + file), 0, "ready");
    expect_says(call(fmt::format("calibrate mount {} --camera down", file)), 2, "there is no camera 'down'");
    expect_says(call(fmt::format("calibrate mount {} --camera up", site())), 2, "turned through");
}

TEST_F(CommandLine, CamerasSaysWhatIsThereAndWhatToDoWhereNothingIs) {
    if (!fs::exists("/dev/video0")) expect_says(call("cameras"), 1, "this machine has no camera: plug one in");
    expect_says(call("cameras /dev/video77"), 1, "no such camera");
    expect_says(call("cameras http://user:secret@127.0.0.1:1/stream"), 1, "http://127.0.0.1:1/stream: no stream comes from there (Connection refused)");
    expect_says(call("cameras " + session() + "/frames/hall1"), 1, "a recording and no camera");
}

TEST_F(CommandLine, EveryCommandHasHelpWithAnExample) {
    for (const char* command : {"demo", "run", "fix", "simulate", "reproduce", "check", "cameras", "doctor", "export", "init", "calibrate mount"})
        expect_says(call(std::string(command) + " --help"), 0, "Example: roomfix");
    expect_says(call("simulate atlantis -o /tmp/x"), 2, "there is no scenario 'atlantis'");
    expect_says(call(fmt::format("simulate li2014 -o {}", session())), 2, "session already");
}

TEST_F(CommandLine, FixFindsTheCameraByACornerInGreyColourAnd16BitPictures) {
    const std::string room = (*folder / "room").string();
    ASSERT_EQ(call(fmt::format("simulate chou1986 --duration 2 --png -o {}", room)).code, 0);
    const std::string picture = room + "/frames/eye/000000000000.png";
    const std::string fix = "fix " + room + "/site.yaml --camera eye ";
    const Outcome grey = call(fix + "--corner c --overlay " + room + "/out " + picture);
    expect_says(grey, 0, "\"camera\": {\"position\": [0.");
    EXPECT_TRUE(fs::exists(room + "/out/000000000000.png"));
    const cv::Mat image = cv::imread(picture, cv::IMREAD_GRAYSCALE);
    cv::Mat colour, deep;
    cv::cvtColor(image, colour, cv::COLOR_GRAY2BGR);
    image.convertTo(deep, CV_16U, 257);
    cv::imwrite(room + "/colour.png", colour);
    cv::imwrite(room + "/deep.png", deep);
    for (const char* name : {"/colour.png", "/deep.png"}) expect_says(call(fix + room + name), 0, "\"status\": \"ok\", \"x\": 0.");
    expect_says(call(fix + "--method published " + room + "/frames/eye/001000000000.png"), 0, "\"image\"");
    cv::imwrite(room + "/blank.png", cv::Mat(480, 640, CV_8U, cv::Scalar(90)));
    expect_says(call(fix + room + "/blank.png"), 0, "the picture is blank");
    cv::imwrite(room + "/row.png", cv::Mat(1, 640, CV_8U, cv::Scalar(90)));
    expect_says(call(fix + room + "/row.png"), 2, "640 x 1 pixels, camera eye has 640 x 480");
    expect_says(call(fix + "--corner x " + picture), 2, "no such corner");
    expect_says(call(fix + "--landmark n1 " + picture), 2, "looks for corners");
    expect_says(call("fix " + site() + " --camera hall1 --corner c " + frame()), 2, "fixed in the map");
}

TEST_F(CommandLine, AFullDiskIsAFailureAndSaysSo) {
    for (const char* smooth : {"", " --smooth"}) {
        expect_says(call(fmt::format("replay {}{} --fixes /dev/full", session(), smooth)), 1, "/dev/full: fixes could not be written and are lost");
    }
}

TEST_F(CommandLine, ReplayGivesTheSameBytesAndEvaluateJudgesThem) {
    const std::string first = (*folder / "first.jsonl").string(), second = (*folder / "second.jsonl").string(), third = (*folder / "third.jsonl").string(),
                      smoothed = (*folder / "smoothed.jsonl").string();
    ASSERT_EQ(call(fmt::format("replay {} --fixes {}", session(), first)).code, 0);
    ASSERT_EQ(call(fmt::format("replay {} --threads 1 --fixes {}", session(), second)).code, 0);
    ASSERT_EQ(call(fmt::format("replay {} --threads 3 --fixes {}", session(), third)).code, 0);
    const std::string fixes = text_of(first);
    EXPECT_GT(std::count(fixes.begin(), fixes.end(), '\n'), 10);
    EXPECT_EQ(fixes, text_of(second));
    EXPECT_EQ(fixes, text_of(third));
    ASSERT_EQ(call(fmt::format("replay {} --smooth --fixes {}", session(), smoothed)).code, 0);
    const std::string after = text_of(smoothed);
    EXPECT_EQ(std::count(after.begin(), after.end(), '\n'), std::count(fixes.begin(), fixes.end(), '\n'));
    EXPECT_NE(after, fixes);
    EXPECT_EQ(fixes.find("latency"), std::string::npos) << "what depends on the clock would not be the same every time";
    const std::string page = (*folder / "report.html").string(), poses = (*folder / "poses").string();
    expect_says(call(fmt::format("evaluate {} --truth {}/truth.csv --report {} --tum {}", first, session(), page, poses)), 0, "identity switches: 0");
    EXPECT_NE(text_of(page).find("</svg>"), std::string::npos);
    EXPECT_NE(text_of(fs::path(poses) / "r1.tum").find(" 0 0 0 "), std::string::npos);
    EXPECT_TRUE(fs::exists(fs::path(poses) / "r1-truth.tum"));
    expect_says(call(fmt::format("evaluate {} --truth {}/odometry.csv", first, session())), 0, "r1");
    expect_says(call(fmt::format("evaluate {} --truth {}/truth.csv --cutoff 0.5", first, session())), 0, "cut-off 0.50 m\nGOSPA  ");
    expect_says(call(fmt::format("evaluate {} --truth {}/truth.csv --cutoff 0", first, session())), 2, "--cutoff");
    expect_says(call(fmt::format("evaluate {} --truth /nowhere.csv", first)), 2, "/nowhere.csv: cannot be opened");
    expect_says(call(fmt::format("evaluate {}/truth.csv --truth {}/truth.csv", session(), session())), 2, "no fix in it");
}

/// The session's truth with the middle's place taken to another point of the robot, without the yaw.
std::string places_of_point(const std::string& truth, double ahead, double left) {
    std::istringstream lines(truth);
    std::string line, places = "time,robot,x,y\n";
    std::getline(lines, line);
    while (std::getline(lines, line)) {
        std::istringstream fields(line);
        std::array<std::string, 5> field;
        for (std::string& f : field) std::getline(fields, f, ',');
        const double yaw = std::stod(field[4]);
        places += fmt::format("{},{},{},{}\n", field[0], field[1], std::stod(field[2]) + std::cos(yaw) * ahead - std::sin(yaw) * left,
                              std::stod(field[3]) + std::sin(yaw) * ahead + std::cos(yaw) * left);
    }
    return places;
}

double rmse_in(const std::string& json_file) { return nlohmann::json::parse(text_of(json_file))["all"]["position"]["rmse"].get<double>(); }

TEST_F(CommandLine, EvaluateTakesATruthOfAnotherPointWithoutYaw) {
    const std::string fixes = (*folder / "point.jsonl").string(), truth = (*folder / "point.csv").string(), numbers = (*folder / "point.json").string();
    ASSERT_EQ(call(fmt::format("replay {} --smooth --fixes {}", session(), fixes)).code, 0);
    std::ofstream(truth) << places_of_point(text_of(session() + "/truth.csv"), 0.2, -0.1);
    const std::string asked = fmt::format("evaluate {} --truth {} --symmetry-deg 90", fixes, truth);
    expect_says(call(fmt::format("{} --json {}", asked, numbers)), 0, "The truth has no yaw beside");
    const double middle = rmse_in(numbers);
    EXPECT_GT(middle, 0.15) << "the truth is about a point 22 cm from the middle";
    const std::string page = (*folder / "point.html").string(), poses = (*folder / "point-tum").string();
    expect_says(call(fmt::format("{} --point 0.2,-0.1,0.4 --json {} --report {} --tum {} --session {}", asked, numbers, page, poses, session())), 0, "bound");
    EXPECT_NE(text_of(page).find("The truth has no yaw beside"), std::string::npos);
    EXPECT_NE(text_of(fs::path(poses) / "r1-truth.tum").find(" 0 0 0 0 1\n"), std::string::npos);
    for (const char* wrong : {"0.2,-0.1", "0.2;-0.1;0.4", "0.2,-0.1,0.4,", "nan,0,0", "200,-100,400"}) {
        expect_says(call(fmt::format("{} --point '{}'", asked, wrong)), 2, "such as 0.2,-0.05,0.4");
    }
    std::ofstream(truth) << "time,robot,x\n1,r1,2\n";
    expect_says(call(asked), 2, "the first line must be time,robot,x,y,yaw or, where no yaw is known, time,robot,x,y");
    const std::string place = (*folder / "place.jsonl").string();
    std::ofstream(place) << R"({"time": 0.5, "robot": "r1", "status": "ok", "x": 1, "y": 1, "yaw": null, "covariance": [1,0,0,0,1,0,0,0,1], "sources": []})";
    expect_says(call(fmt::format("evaluate {} --truth {}/truth.csv --point 0.2,0,0", place, session())), 2, "leave --point out");
}

TEST_F(CommandLine, ASessionWithADamagedMiddleIsReplayedAroundIt) {
    const fs::path copy = *folder / "damaged";
    fs::copy(session(), copy, fs::copy_options::recursive);
    std::ofstream(copy / "frames/hall1/000500000000.jpg") << "no picture";
    fs::remove(copy / "frames/hall1/000600000000.jpg");
    const Outcome outcome = call(fmt::format("replay {} --fixes {}", copy.string(), (*folder / "damaged.jsonl").string()));
    expect_says(outcome, 0, "1 bad");
    EXPECT_NE(text_of(*folder / "damaged.jsonl").find("\"time\": 1.1"), std::string::npos);
    fs::remove(copy / "odometry.csv");
    expect_says(call(fmt::format("replay {}", copy.string())), 2, "odometry.csv: cannot be read");
    fs::remove(copy / "site.yaml");
    expect_says(call(fmt::format("replay {}", copy.string())), 2, "site");
}

}  // namespace
}  // namespace roomfix
