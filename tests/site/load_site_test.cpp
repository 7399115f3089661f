#include "roomfix/site/load_site.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "roomfix/site/lens_grid_file.hpp"
#include "roomfix/site/site_text.hpp"

namespace roomfix {
namespace {

const std::string good = R"(roomfix: 1
site: {name: lab, ceiling: 3.0, walls: [[[0, 0], [6, 0], [6, 5]]]}
cameras:
  hall:
    source: frames/hall
    size: [640, 480]
    intrinsics: {fx: 518.38, fy: 518.07, cx: 318.0, cy: 239.5}
    pose: {position: [2.79, 5.70, 2.30], quaternion: [0.5, -0.5, 0.5, -0.5]}
  up:
    source: frames/up
    size: [352, 288]
    intrinsics: {fx: 300, fy: 300, cx: 175.5, cy: 143.5}
    mount: {robot: r1, position: [0, 0, 0.3], quaternion: [0, 0, 0, 1]}
robots:
  r1: {shape: box, size: [0.54, 0.54, 0.45]}
  cart: {shape: cylinder, size: [0.5, 1.7], count: many}
  lift: {shape: box, size: [0.8, 0.6, 0.4], receiver: {position: [0, 0, 0.4], source: /dev/ttyUSB0}, tag: {id: 7, size: 0.12, position: [0, 0, 0.4], yaw_deg: 90}}
landmarks:
  n1: {position: [1.0, 1.25, 3.0], yaw_deg: 90, legs: [0.10, 0.15], beacon: n1}
  t5: {position: [2.0, 1.25, 3.0], tag: 5, size: 0.16}
  door: {position: [0, 2, 1.5], yaw_deg: 180, tag: 6, size: 0.2, facing: wall, sigma: 0.004}
beacons:
  n1: {position: [1.0, 1.25, 3.0], address: "01:25:61:61:0b:00:00:42"}
corners:
  nw: {position: [0, 0, 2.7], yaw_deg: 0}
)";

std::string with(std::string text, const std::string& from, const std::string& to) {
    const auto at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return text.replace(at, from.size(), to);
}

const Problem* problem_with(const LoadedSite& loaded, const std::string& words) {
    for (const auto& p : loaded.problems) {
        if (p.message.find(words) != std::string::npos) return &p;
    }
    return nullptr;
}

TEST(LoadSite, ACornersMouldingIsReadAndWrittenBack) {
    const LoadedSite plain = parse_site(good, "/somewhere");
    ASSERT_TRUE(plain.usable());
    EXPECT_FALSE(plain.site.corners.at(0).moulding);
    const LoadedSite loaded = parse_site(with(good, "yaw_deg: 0}\n", "yaw_deg: 0, moulding: 0.08}\n"), "/somewhere");
    ASSERT_TRUE(loaded.usable());
    EXPECT_EQ(loaded.site.corners.at(0).moulding, 0.08);
    const LoadedSite again = parse_site(site_text(loaded.site), "/somewhere");
    ASSERT_TRUE(again.usable());
    EXPECT_EQ(again.site.corners.at(0).moulding, 0.08);
    const LoadedSite none = parse_site(with(good, "yaw_deg: 0}\n", "yaw_deg: 0, moulding: 0}\n"), "/somewhere");
    ASSERT_TRUE(none.usable());
    EXPECT_EQ(parse_site(site_text(none.site), "/somewhere").site.corners.at(0).moulding, 0) << "stated that there is none";
}

TEST(LoadSite, ReadsEverything) {
    const LoadedSite loaded = parse_site(good, "/somewhere");
    for (const auto& p : loaded.problems) EXPECT_FALSE(p.fatal) << p.message;
    const Site& site = loaded.site;
    ASSERT_EQ(site.cameras.size(), 2U);
    EXPECT_EQ(site.cameras[0].id, "hall");
    EXPECT_EQ(site.cameras[0].model.fx, 518.38);
    EXPECT_TRUE(std::holds_alternative<Mount>(site.cameras[1].placement));
    ASSERT_EQ(site.robots.size(), 3U);
    EXPECT_TRUE(site.robots[1].many);
    EXPECT_LT((map_points(site.landmarks[0])[1] - Eigen::Vector3d(1.075, 1.30, 3.0)).norm(), 1e-12) << "leg a points along yaw";
    // Corners as the tag is read: bottom left first, then counter-clockwise for the reader.
    const auto ceiling_tag = map_points(site.landmarks[1]);
    EXPECT_LT((ceiling_tag[0] - Eigen::Vector3d(1.92, 1.17, 3)).norm(), 1e-12) << "from below, with x up, y points to the left";
    EXPECT_LT((ceiling_tag[1] - Eigen::Vector3d(1.92, 1.33, 3)).norm(), 1e-12);
    const auto door = map_points(site.landmarks[2]);
    EXPECT_LT((door[3] - Eigen::Vector3d(0, 1.9 + 0.2, 1.6)).norm(), 1e-12) << "for who looks along +x at the door, left is +y";
    EXPECT_LT((site.robots[2].robot_from_tag.linear().col(1) - Eigen::Vector3d(0, 1, 0)).norm(), 1e-12) << "its upper edge points to the robot's left";
    EXPECT_EQ(site.robots[2].receiver()->source, "/dev/ttyUSB0");
    EXPECT_EQ(resolved_path(site, "frames/hall"), "/somewhere/frames/hall");
    EXPECT_EQ(resolved_path(site, "rtsp://camera/1"), "rtsp://camera/1");
    EXPECT_TRUE(problem_with(loaded, "no covariance")) << "a note says that the calibration is left out";
}

TEST(LoadSite, ReportsAllMistakesAtOnceWithTheirPlaces) {
    std::string text = with(good, "fx: 518.38", "fx: wide");
    text = with(text, "shape: box", "shape: ball");
    text = with(text, "    source: frames/up", "    sorce: frames/up");
    text = with(text, "beacon: n1", "beacon: n9");
    text = with(text, "quaternion: [0, 0, 0, 1]", "quaternion: [0, 0, 0, 2]");
    const LoadedSite loaded = parse_site(text, "/");
    EXPECT_FALSE(loaded.usable());
    const struct {
        const char* words;
        int line, column;
    } expected[] = {{"fx must be a number, not 'wide'", 7, 22},
                    {"no key 'sorce': did you mean 'source'?", 10, 5},
                    {"needs the key 'source'", 10, 5},
                    {"shape must be box or cylinder, not 'ball'", 15, 15},
                    {"no beacon 'n9'", 19, 77}};
    for (const auto& e : expected) {
        const Problem* p = problem_with(loaded, e.words);
        ASSERT_TRUE(p) << e.words;
        EXPECT_EQ(p->line, e.line) << e.words;
        EXPECT_EQ(p->column, e.column) << e.words;
    }
    EXPECT_TRUE(problem_with(loaded, "must lie between -1.01 and 1.01")) << "the quaternion";
}

TEST(LoadSite, SaysWhatIsWrongWithOneThing) {
    const struct {
        const char* from;
        const char* to;
        const char* words;
    } cases[] = {
        {"roomfix: 1", "roomfix: 2", "not format 1"},
        {"size: [640, 480]", "size: [0, 480]", "must lie between"},
        {"size: [640, 480]", "size: 640", "list of 2 numbers"},
        {"    pose: {position: [2.79, 5.70, 2.30], quaternion: [0.5, -0.5, 0.5, -0.5]}\n", "", "where is the camera"},
        {"[0.5, -0.5, 0.5, -0.5]}", "[0.5, -0.5, 0.5, -0.5]}\n    height: 2", "keep one of them"},
        {"robot: r1", "robot: r7", "no robot 'r7'"},
        {"  up:", "  hall:", "stands twice"},
        {"  up:", "  'a b':", "letters, digits"},
        {"  up:", "  u\xff:", "save the file as UTF-8"},
        {"  up:", "  \"u\\x7f\":", "'u?'"},
        {"count: many", "count: lots", "must be 'many' or 1"},
        {"size: [0.54, 0.54, 0.45]", "size: [0.54, 0, 0.45]", "must lie between"},
        {"tag: 5, size: 0.16", "tag: 5", "needs the key 'size'"},
        {"tag: 5, size: 0.16", "size: 0.16", "belongs to a tag"},
        {"legs: [0.10, 0.15]", "legs: [0.10, 0.15], tag: 3", "only one of"},
        {"tag: 6", "tag: 5", "already"},
        {"facing: wall", "facing: north", "facing must be"},
        {"  n1: {position: [1.0, 1.25, 3.0], address", "  n2: {position: [1, 1, 3], address: n1}\n  n1: {position: [1.0, 1.25, 3.0], address",
         "called the same"},
        {"corners:", "  n2: {position: [1, 1, 3], address: \"01:25:61:61:0b:00:00:42\"}\ncorners:", "called the same"},
        {"id: 7, size: 0.12", "id: 700, size: 0.12", "between 0 and 586"},
        {"position: [0, 0, 2.7]", "position: [0, 0, 0]", "high above the floor"},
        {"position: [0, 0, 2.7]", "position: [0, 0, -2.7]", "high above the floor"},
        {"position: [0, 0, 2.7]", "position: [0, 0]", "list of 3 numbers"},
        {"nw: {position: [0, 0, 2.7], yaw_deg: 0}", "nw: {yaw_deg: 0}", "needs the key 'position'"},
        {"yaw_deg: 0}\n", "yaw_deg: 0, angle_deg: 180}\n", "between 20 and 160"},
        {"yaw_deg: 0}\n", "yaw_deg: 0, moulding: 0.0001}\n", "or 0 if there is none"},
        {"yaw_deg: 0}\n", "yaw_deg: 0, moulding: -0.08}\n", "corners.nw.moulding"},
        {"yaw_deg: 0}\n", "yaw_deg: 0, moulding: 8}\n", "corners.nw.moulding"},
        {"    mount: {robot: r1, position: [0, 0, 0.3], quaternion: [0, 0, 0, 1]}\n", "    height: 2.7\n    robot: r1\n", "must be below the ceiling"},
        {"count: many", "count: many, receiver: {position: [0, 0, 1]}", "an entry of its own"},
    };
    for (const auto& c : cases) {
        const LoadedSite loaded = parse_site(with(good, c.from, c.to), "/");
        EXPECT_FALSE(loaded.usable()) << c.to;
        EXPECT_TRUE(problem_with(loaded, c.words)) << c.to;
    }
    for (const char* text : {"", "[", "just text", "roomfix: 1", "{a: b", "- 1\n- 2", "&a [*a]"}) EXPECT_FALSE(parse_site(text, "/").usable()) << text;
}

TEST(LoadSite, FloorPointsThatDoNotFixThePoseAreAnError) {
    const std::string pose = "    pose: {position: [2.79, 5.70, 2.30], quaternion: [0.5, -0.5, 0.5, -0.5]}\n";
    const auto floor = [&](const char* points) { return parse_site(with(good, pose, std::string("    floor_points: [") + points + "]\n"), "/"); };
    const auto few = floor("{pixel: [100, 300], map: [3, 5]}, {pixel: [200, 300], map: [3, 6]}, {pixel: [200, 400], map: [4, 6]}");
    ASSERT_TRUE(problem_with(few, "four or more are needed"));
    EXPECT_EQ(problem_with(few, "four or more are needed")->line, 8);
    const auto line =
        floor("{pixel: [100, 300], map: [3, 5]}, {pixel: [200, 300], map: [3, 6]}, {pixel: [300, 300], map: [3, 7]}, {pixel: [400, 300], map: [3, 8]}");
    EXPECT_TRUE(problem_with(line, "on one line"));
}

TEST(SiteText, ReadsBackAsTheSameSite) {
    Site site = parse_site(good, "/").site;
    site.lost = 0.9;
    const LoadedSite again = parse_site(site_text(site), "/");
    EXPECT_EQ(again.site.lost, 0.9);
    for (const auto& p : again.problems) EXPECT_FALSE(p.fatal) << p.message;
    EXPECT_EQ(site_text(again.site), site_text(site));
    EXPECT_EQ(again.site.cameras.size(), site.cameras.size());
    EXPECT_EQ(again.site.walls, site.walls);
}

TEST(LoadSite, ReadsDriveOdometryAndTheRangesErrorsAndWritesThemAgain) {
    const std::string text =
        with(with(good, "r1: {shape: box,",
                  "r1: {drive: differential, odometry: {source: wheels.csv, scale_sigma: 0.03, turn_scale_sigma: 0.04, drift_sigma: 0.002}, "
                  "detector: {position: [0.1, 0, 0.2], position_sigma: 0.01, bearing_sigma: 0.02}, shape: box,"),
             "source: /dev/ttyUSB0", "source: /dev/ttyUSB0, bias_sigma: 0.5, scale_sigma: 0.01");
    const LoadedSite first = parse_site(text, "/somewhere");
    for (const auto& p : first.problems) EXPECT_FALSE(p.fatal) << p.message;
    const LoadedSite again = parse_site(site_text(first.site), "/somewhere");
    for (const LoadedSite& loaded : {first, again}) {
        const SiteRobot& robot = loaded.site.robots[0];
        EXPECT_EQ(robot.drive, Drive::differential);
        ASSERT_TRUE(robot.odometry);
        EXPECT_EQ(robot.odometry->source, "wheels.csv");
        EXPECT_EQ(robot.odometry->scale_sigma, 0.03);
        EXPECT_EQ(robot.odometry->turn_scale_sigma, 0.04);
        EXPECT_EQ(robot.odometry->drift_sigma, 0.002);
        ASSERT_TRUE(robot.detector);
        EXPECT_EQ(robot.detector->position, Eigen::Vector3d(0.1, 0, 0.2));
        EXPECT_EQ(robot.detector->position_sigma, Eigen::Vector3d::Constant(0.01));
        EXPECT_EQ(robot.detector->bearing_sigma, 0.02);
        EXPECT_EQ(loaded.site.robots[2].receiver()->bias_sigma, 0.5);
        EXPECT_EQ(loaded.site.robots[2].receiver()->scale_sigma, 0.01);
    }
}

TEST(LoadSite, ReadsHowFarACamerasClockMayBeOffAndWritesItAgain) {
    const LoadedSite first = parse_site(with(good, "    size: [640, 480]", "    size: [640, 480]\n    time_offset_sigma: 0.05"), "/somewhere");
    for (const auto& p : first.problems) EXPECT_FALSE(p.fatal) << p.message;
    EXPECT_EQ(first.site.cameras[0].time_offset_sigma, 0.05);
    EXPECT_EQ(first.site.cameras[1].time_offset_sigma, 0);
    EXPECT_EQ(parse_site(site_text(first.site), "/somewhere").site.cameras[0].time_offset_sigma, 0.05);
    EXPECT_TRUE(
        problem_with(parse_site(with(good, "    size: [640, 480]", "    size: [640, 480]\n    time_offset_sigma: -1"), "/somewhere"), "time_offset_sigma"));
}

TEST(LoadSite, ReadsHowACameraTakesItsPicturesAndWritesItAgain) {
    const auto camera = [](const std::string& lines) { return parse_site(with(good, "    size: [640, 480]", "    size: [640, 480]\n" + lines), "/somewhere"); };
    const LoadedSite first = camera("    delay: 0.08\n    readout: 0.03\n    capture: {rate: 30, exposure: 0.005, gain: 12, white_balance: 4500}");
    for (const auto& p : first.problems) EXPECT_FALSE(p.fatal) << p.message;
    for (const Site& site : {first.site, parse_site(site_text(first.site), "/somewhere").site}) {
        const CaptureSettings& capture = site.cameras[0].capture;
        EXPECT_EQ(capture.rate, 30);
        EXPECT_EQ(capture.exposure, 0.005);
        EXPECT_EQ(capture.gain, 12);
        EXPECT_EQ(capture.white_balance, 4500);
        EXPECT_EQ(capture.delay, 0.08);
        EXPECT_EQ(capture.readout, 0.03);
        EXPECT_EQ(site.cameras[1].capture.readout, 0);
        EXPECT_FALSE(site.cameras[1].capture.delay);
    }
    EXPECT_TRUE(problem_with(camera("    delay: -1"), "delay"));
    EXPECT_TRUE(problem_with(camera("    readout: 30"), "readout"));
    EXPECT_TRUE(problem_with(camera("    capture: {exposure: 5}"), "exposure"));
    EXPECT_TRUE(problem_with(camera("    capture: {shutter: 1}"), "shutter"));
}

TEST(LoadSite, ReadsLensesOfAllKindsWithTheirCovarianceAndWritesThemAgain) {
    SiteCamera camera = parse_site(good, "/somewhere").site.cameras[0];
    for (const Distortion kind : {Distortion::plumb_bob, Distortion::rational_polynomial, Distortion::equidistant}) {
        Site site = parse_site(good, "/somewhere").site;
        camera.model = make_camera_model(640, 480, 500, 501, 320, 240, {0.1, 0.02, 0.001, 0.002}, kind);
        const int count = camera.model.intrinsics_count();
        camera.intrinsics_covariance.setZero();
        camera.intrinsics_covariance.diagonal().head(count).setLinSpaced(0.1, 0.5);
        camera.intrinsics_covariance(0, 1) = camera.intrinsics_covariance(1, 0) = 0.05;
        KnownPose known{{looking_at({0, 0, 2}, {3, 0, 0}), 1e-6 * Matrix6d::Identity()}, true};
        known.by_intrinsics.leftCols(count).setConstant(0.25);
        camera.placement = known;
        site.cameras[0] = camera;
        const LoadedSite again = parse_site(site_text(site), "/somewhere");
        for (const auto& p : again.problems) EXPECT_FALSE(p.fatal) << p.message;
        const SiteCamera& read = again.site.cameras[0];
        EXPECT_EQ(read.model.kind, kind);
        EXPECT_EQ(read.model.distortion, camera.model.distortion);
        EXPECT_EQ(read.intrinsics_covariance, camera.intrinsics_covariance);
        EXPECT_EQ(std::get<KnownPose>(read.placement).by_intrinsics, known.by_intrinsics);
        // The fixes of such a camera are less certain than those of one whose lens is known exactly.
        const View exact{camera.model, known.map_from_camera}, uncertain = *fixed_view(read);
        EXPECT_GT(uncertain.calibration.norm(), 10 * exact.calibration.norm());
    }
    EXPECT_TRUE(problem_with(parse_site(with(good, "    size: [640, 480]", "    size: [640, 480]\n    distortion_model: fish"), "/"),
                             "plumb_bob, rational_polynomial or equidistant"));
    EXPECT_TRUE(problem_with(parse_site(with(good, "    size: [640, 480]", "    size: [640, 480]\n    lens_grid: none.csv"), "/"), "none.csv"));
}

TEST(LensGridFile, ReadsBackAndNamesTheLineThatIsWrong) {
    std::string text = "column,row,u,v,ideal_u,ideal_v\n";
    for (int i = 0; i < 12; ++i)
        text += std::to_string(i % 4) + "," + std::to_string(i / 4) + "," + std::to_string(10 * (i % 4)) + "," + std::to_string(10 * (i / 4)) + ",0" +
                std::to_string(11 * (i % 4)) + "," + std::to_string(11 * (i / 4)) + "\n";
    const auto grid = parse_lens_grid(text);
    ASSERT_TRUE(grid) << grid.error().message;
    EXPECT_EQ(grid->columns(), 4);
    EXPECT_EQ(lens_grid_text(*parse_lens_grid(lens_grid_text(*grid))), lens_grid_text(*grid));
    EXPECT_NE(parse_lens_grid("u,v\n").error().message.find("line 1"), std::string::npos);
    EXPECT_NE(parse_lens_grid(text + "0,3,x,1,1,1\n").error().message.find("line 14"), std::string::npos);
    EXPECT_NE(parse_lens_grid(text + "2,3,1,1,1,1\n").error().message.find("row by row"), std::string::npos);
    EXPECT_FALSE(parse_lens_grid(text + "0,3,1,40,1,40\n")) << "half a row";
    EXPECT_FALSE(parse_lens_grid(""));
}

TEST(LoadSite, RefusesAnUnknownDriveAndOdometryOfMany) {
    const LoadedSite drive = parse_site(with(good, "r1: {shape: box,", "r1: {drive: legs, shape: box,"), "/somewhere");
    EXPECT_TRUE(problem_with(drive, "must be differential, holonomic or unknown, not 'legs'"));
    const LoadedSite many = parse_site(with(good, "count: many", "count: many, odometry: {source: wheels.csv}"), "/somewhere");
    EXPECT_TRUE(problem_with(many, "robots.cart.odometry: there are many of this robot"));
}

TEST(LoadSite, WheelsMayComeOnARosTopicThatIsNobodyElses) {
    const auto sources = [](const std::string& of_r1, const std::string& of_lift) {
        const std::string one = with(good, "r1: {shape: box,", "r1: {odometry: {source: '" + of_r1 + "'}, shape: box,");
        return with(one, "lift: {shape: box,", "lift: {odometry: {source: '" + of_lift + "'}, shape: box,");
    };
    for (const Problem& problem : parse_site(sources("ros2:/r1/odom", "ros2:/lift_2/odom"), "/somewhere").problems)
        EXPECT_FALSE(problem.fatal) << problem.message;
    EXPECT_TRUE(problem_with(parse_site(sources("ros2:/odom", "ros2:/odom"), "/somewhere"), "robots.lift has the same odometry source as r1"));
    for (const char* name : {"odom", "", "/", "/r1/", "//odom", "/1/odom", "/a-b", "/a__b", "/a b"}) {
        EXPECT_TRUE(problem_with(parse_site(sources(std::string("ros2:") + name, "x.csv"), "/somewhere"), "write the whole name of a topic")) << name;
    }
    EXPECT_TRUE(problem_with(parse_site(with(good, "source: /dev/ttyUSB0", "source: 'ros2:/ranges'"), "/somewhere"),
                             "robots.lift has a source 'ros2:...' that is not its odometry's"));
}

TEST(LoadSession, GivesRobotsTheFoldersOdometryWhereTheSiteFileNamesNone) {
    const auto folder = std::filesystem::temp_directory_path() / "roomfix_load_session";
    std::filesystem::create_directories(folder);
    std::ofstream(folder / "site.yaml") << with(good, "lift: {shape: box,", "lift: {odometry: {source: lift.csv}, shape: box,");
    std::filesystem::remove(folder / "odometry.csv");
    const auto without = load_session(folder);
    ASSERT_TRUE(without) << without.error().message;
    EXPECT_FALSE(without->robots[0].odometry);
    std::ofstream(folder / "odometry.csv") << "time,robot,x,y,yaw\n0,r1,0,0,0\n0,lift,0,0,0\n";
    const auto found = load_session(folder);
    ASSERT_TRUE(found) << found.error().message;
    ASSERT_TRUE(found->robots[0].odometry);
    EXPECT_EQ(found->robots[0].odometry->source, "odometry.csv");
    EXPECT_EQ(found->robots[2].odometry->source, "lift.csv");
    EXPECT_FALSE(load_session(folder / "site.yaml")->robots[0].odometry) << "a site file alone is no session";
    std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace roomfix
