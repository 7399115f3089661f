// `roomfix calibrate lens`, `floor` and `grid` as their users call them, and what they say to bad input.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "acceptance/data_folder.hpp"
#include "acceptance/program.hpp"
#include "roomfix/calibrate/floor.hpp"
#include "roomfix/connect/camera_info.hpp"
#include "roomfix/imaging/load_luma.hpp"
#include "roomfix/simulate/camera_renderer.hpp"
#include "roomfix/simulate/plane_picture.hpp"
#include "roomfix/simulate/room_shots.hpp"
#include "roomfix/site/load_site.hpp"

namespace roomfix {
namespace {

namespace fs = std::filesystem;

CameraModel true_camera() { return make_camera_model(640, 480, 533, 535, 327, 235, {-0.2, 0.05, 0.001, -0.0006, 0}); }

class Calibrate : public ::testing::Test {
protected:
    static void SetUpTestSuite() {
        folder = new fs::path(fs::temp_directory_path() / fmt::format("roomfix_calibrate_{}", getpid()));
        fs::remove_all(*folder);
        fs::create_directories(*folder / "boards");
        Random random(21);
        PlanePictures pictures(true_camera(), {}, 3);
        LumaImage picture;
        int number = 0;
        for (const Eigen::Isometry3d& pose : board_poses(true_camera(), {0.2, 0.125}, 9, random)) {
            pictures.render(chessboard_pattern(9, 6, 0.025), pose, static_cast<std::uint64_t>(number), picture);
            ASSERT_TRUE(save_luma(*folder / "boards" / fmt::format("board{}.png", number++), picture));
        }
        const View view{true_camera(), {looking_at({0, 0, 2.4}, {4, 0.1, 0}), Matrix6d::Zero()}};
        CameraRenderer(Scene{}, view, {}, 1).render({}, 1, 0, picture);
        ASSERT_TRUE(save_luma(*folder / "floor.png", picture));
        for (const Eigen::Vector2d& corner : {Eigen::Vector2d(3, 0), {3.3, 0}, {3.3, 0.3}, {3, 0.3}}) {
            const Eigen::Vector2d pixel = *project_map_point(view, {corner.x(), corner.y(), 0});
            tile += fmt::format("{:.1f},{:.1f} ", pixel.x(), pixel.y());
        }
    }
    static void TearDownTestSuite() {
        fs::remove_all(*folder);
        delete folder;
    }
    /// A fresh site file with a comment in it.
    void SetUp() override {
        std::ofstream(site()) << "roomfix: 1\nsite: {name: lab}\ncameras:\n  hall:  # above the door\n    source: floor.png\n    size: [640, 480]\n"
                                 "    intrinsics: {fx: 533, fy: 535, cx: 327, cy: 235}\n    distortion: [-0.2, 0.05, 0.001, -0.0006, 0]\n"
                                 "    pose: {position: [0, 0, 2], quaternion: [0.5, -0.5, 0.5, -0.5]}\nrobots:\n  r1: {shape: box, size: [0.5, 0.5, 0.5]}\n";
    }
    static std::string site() { return (*folder / "site.yaml").string(); }
    static std::string boards() { return (*folder / "boards").string(); }
    static std::string in(const std::string& file) { return (*folder / file).string(); }
    static fs::path* folder;
    static std::string tile;
};
fs::path* Calibrate::folder = nullptr;
std::string Calibrate::tile;

TEST_F(Calibrate, LensGoesFromPicturesToTheSiteFile) {
    const Outcome made =
        call(fmt::format("calibrate lens {} --report {} --camera-info {} --site {} --camera hall --write", boards(), in("lens.html"), in("info.yaml"), site()));
    expect_says(made, 0, "9 of 9 shots used");
    const auto loaded = load_site(site());
    ASSERT_TRUE(loaded) << loaded.error().message;
    const SiteCamera& hall = loaded->cameras[0];
    EXPECT_NEAR(hall.model.fx, 533, 4 * std::sqrt(hall.intrinsics_covariance(0, 0)));
    EXPECT_GT(hall.intrinsics_covariance(0, 0), 0);
    const auto info = load_camera_info(in("info.yaml"));
    ASSERT_TRUE(info) << info.error().message;
    EXPECT_EQ(info->model.fx, hall.model.fx);
    std::ifstream file(site());
    EXPECT_NE(std::string(std::istreambuf_iterator<char>(file), {}).find("# above the door"), std::string::npos);
    // A worse one does not replace it: fewer shots, and no covariance at all.
    expect_says(call(fmt::format("calibrate lens {0}/board0.png {0}/board1.png {0}/board2.png {0}/board3.png {0}/board4.png --site {1} --camera hall --write",
                                 boards(), site())),
                1, "--force replaces it");
    expect_says(call(fmt::format("calibrate lens --from {} --site {} --camera hall --write", in("info.yaml"), site())), 1, "has a better calibration");
    expect_says(call(fmt::format("calibrate lens --from {} --site {} --camera hall --write --force", in("info.yaml"), site())), 0, "written");
}

TEST_F(Calibrate, LensSaysWhatIsWrong) {
    expect_says(call("calibrate lens"), 2, "no pictures");
    expect_says(call(fmt::format("calibrate lens {}", in("floor.png"))), 2, "no picture shows a board");
    expect_says(call(fmt::format("calibrate lens {} --board 8x6", boards())), 2, "give --board 9x6");
    expect_says(call(fmt::format("calibrate lens {} --board 9by6", boards())), 2, "such as 9x6");
    expect_says(call(fmt::format("calibrate lens {0}/board0.png {0}/board0.png {0}/board0.png {0}/board0.png", boards())), 2, "shows the board where");
    expect_says(call(fmt::format("calibrate lens {} --write", boards())), 2, "--write needs --site");
    expect_says(call(fmt::format("calibrate lens {} --site {} --camera door", boards(), site())), 2, "no camera 'door'");
    expect_says(call(fmt::format("calibrate lens --from {}", site())), 2, "image_width and image_height");
    // Another resolution of the same picture is scaled; another shape is not.
    std::ofstream(in("large.yaml")) << camera_info_text({"hall", make_camera_model(1280, 960, 1066, 1070, 654.5, 470.5)});
    expect_says(call(fmt::format("calibrate lens --from {} --site {} --camera hall", in("large.yaml"), site())), 0, "scaled from 1280 x 960");
    std::ofstream(in("wide.yaml")) << camera_info_text({"hall", make_camera_model(1280, 720, 1066, 1070, 654.5, 360.5)});
    expect_says(call(fmt::format("calibrate lens --from {} --site {} --camera hall", in("wide.yaml"), site())), 2, "another shape");
    LumaImage small(320, 240);
    ASSERT_TRUE(save_luma(in("small.png"), small));
    expect_says(call(fmt::format("calibrate lens {}/board0.png {}", boards(), in("small.png"))), 2, "one resolution at a time");
    expect_says(call(fmt::format("calibrate lens --print-board {}", in("board.svg"))), 0, "print it at 100 %");
}

TEST_F(Calibrate, FloorGoesFromOneTileToTheSiteFile) {
    const std::string asked = fmt::format("calibrate floor {} --camera hall --tile \"{}\" --tile-at 3,0,0", site(), tile);
    expect_says(call(asked + " --overlay " + in("overlay.png")), 0, "tile grid");
    EXPECT_TRUE(fs::exists(in("overlay.png")));
    expect_says(call(asked + " --write"), 0, "camera hall written");
    const auto loaded = load_site(site());
    ASSERT_TRUE(loaded);
    const auto& pose = std::get<KnownPose>(loaded->cameras[0].placement);
    EXPECT_TRUE(pose.has_covariance);
    EXPECT_LT((pose.map_from_camera.pose.translation() - Eigen::Vector3d(0, 0, 2.4)).norm(), 0.02);
    expect_says(call(asked + " --no-grid --write"), 1, "--force replaces it");
    // Something stands where the new file is to be written: nothing changes.
    const std::string before = text_of(site());
    fs::create_directory(site() + ".new");
    expect_says(call(asked + " --write --force"), 2, "cannot be written");
    EXPECT_EQ(text_of(site()), before);
    fs::remove(site() + ".new");
}

TEST_F(Calibrate, FloorSaysWhatIsWrong) {
    const std::string asked = fmt::format("calibrate floor {} --camera hall ", site());
    expect_says(call(asked), 2, "nothing tells where the camera is");
    expect_says(call(asked + "--point 1,2=3,4 --point 5,6=7,8 --point 9,9=1,1"), 2, "four or more are needed");
    expect_says(call(asked + "--point 1,2"), 2, "such as 321.5,240=1.2,3.4");
    expect_says(call(fmt::format("calibrate floor --point 1,2=3,4 {} --camera hall", site())), 2, "four or more are needed");
    expect_says(call(asked + "--tile \"1,2 3,4\""), 2, "a tile has four corners, 2 were given");
    expect_says(call(asked + fmt::format("--tile \"{}\" --tile-size-mm 0", tile)), 2, "--tile-size-mm");
    expect_says(call(asked + fmt::format("--tile \"{}\" --tile-at 1,2", tile)), 2, "--tile-at");
    expect_says(call(asked + "--corner nw"), 2, "add --height");
    expect_says(call(asked + "--corner nw --height 2.4"), 2, "no such corner");
    expect_says(call(asked + fmt::format("--tile \"{}\" --picture {}/none.png", tile, boards())), 2, "none.png");
    // Clicked clockwise: the floor would be seen from below.
    std::vector<std::string> corners;
    std::istringstream stream(tile);
    for (std::string c; stream >> c;) corners.push_back(c);
    expect_says(call(asked + fmt::format("--tile \"{} {} {} {}\"", corners[0], corners[3], corners[2], corners[1])), 2, "check their order");
}

TEST_F(Calibrate, GridWritesALensThatTheSiteUses) {
    PlanePictures pictures(true_camera(), {}, 5);
    LumaImage picture;
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.translation() = Eigen::Vector3d(-0.3 - 0.01, -0.21, 0.6);
    pictures.render(chessboard_pattern(21, 15, 0.03), pose, 0, picture);
    ASSERT_TRUE(save_luma(in("grid.png"), picture));
    const std::string asked = fmt::format("calibrate grid {} --board 21x15 --square-mm 30 --distance 0.6 --centre 327 235 -o {} --site {} --camera hall",
                                          in("grid.png"), in("lens.csv"), site());
    expect_says(call(asked + " --corrected " + in("corrected.png")), 0, "focal length: 53");
    expect_says(call(asked + " --write"), 0, "written");
    const auto loaded = load_site(site());
    ASSERT_TRUE(loaded) << loaded.error().message;
    ASSERT_TRUE(loaded->cameras[0].model.grid);
    EXPECT_NEAR(std::sqrt(loaded->cameras[0].intrinsics_covariance(0, 0)), 533 * 0.005 / 0.6, 0.1) << "as well as the distance is known";
    // A ray inside the grid goes where the true lens has it.
    const auto ray = unproject(loaded->cameras[0].model, {450, 330}), truly = unproject(true_camera(), {450, 330});
    ASSERT_TRUE(ray && truly);
    EXPECT_LT((*ray - *truly).norm() * 533, 2.5);
    expect_says(call(fmt::format("calibrate grid {} --distance 0.6 -o {}", in("floor.png"), in("x.csv"))), 2, "all of it must be in the picture");
    expect_says(call(asked + " --wall 0 0 10 0 0 5 10 5"), 2, "must run along the view");
    expect_says(call(fmt::format("calibrate grid --wall 0 0 10 0 0 5 10 5 {} --distance 0.6 -o {}", in("floor.png"), in("x.csv"))), 2,
                "all of it must be in the picture");
}

TEST_F(Calibrate, LinesOfARoomMadeStraightGoIntoTheSiteFile) {
    RoomRenderer renderer(true_camera(), room_sensor(), {}, 6);
    Random random(6);
    std::filesystem::create_directories(in("rooms"));
    LumaImage picture;
    for (int i = 0; i < 8; ++i) {
        const RoomShot shot = cluttered_shot(random);
        renderer.render(shot.scene, shot.map_from_camera, shot.light, static_cast<std::uint64_t>(i), picture);
        ASSERT_TRUE(save_luma(in(fmt::format("rooms/{}.png", i)), picture));
    }
    const std::string asked = fmt::format("calibrate lines {} {} --camera hall", site(), in("rooms"));
    expect_says(call(asked + " --overlay " + in("lines.png")), 0, "straight lines do not tell the focal length");
    EXPECT_TRUE(std::filesystem::exists(in("lines.png")));
    expect_says(call(asked + " --write --force"), 0, "written");
    const auto loaded = load_site(site());
    ASSERT_TRUE(loaded) << loaded.error().message;
    EXPECT_NEAR(loaded->cameras[0].model.distortion[0], true_camera().distortion[0], 0.03);
    EXPECT_GT(loaded->cameras[0].intrinsics_covariance(4, 4), 0);
    expect_says(call(fmt::format("calibrate lines {} {} --camera hall", site(), in("rooms/0.png"))), 2, "take pictures with door frames");
    expect_says(call(fmt::format("calibrate lines {} {} --camera hall", site(), in("nowhere"))), 2, "nowhere");
}

TEST_F(Calibrate, MountFromADriveUsesTheWheels) {
    ASSERT_EQ(call(fmt::format("simulate kim2011-drive -o {}", in("drive"))).code, 0);
    const std::string asked = fmt::format("calibrate mount {} --camera up", in("drive/site.yaml"));
    expect_says(call(asked + " --no-odometry"), 2, "did not keep to one spot");
    expect_says(call(asked + " --odometry " + in("nothing.csv")), 2, "nothing.csv");
    expect_says(call(asked + " --write"), 0, "the robot drove");
    const auto loaded = load_site(in("drive/site.yaml"));
    ASSERT_TRUE(loaded) << loaded.error().message;
    EXPECT_TRUE(std::get<Mount>(loaded->cameras[0].placement).has_covariance);
    expect_says(call(fmt::format("calibrate mount {} --camera hall", site())), 2, "rides on no robot");
}

TEST_F(Calibrate, SiteCalibratesAllCamerasFromADrive) {
    ASSERT_EQ(call(fmt::format("simulate li2014 --duration 4 -o {}", in("session"))).code, 0);
    const auto before = load_site(in("session/site.yaml"));
    ASSERT_TRUE(before) << before.error().message;
    const std::string asked = fmt::format("calibrate site {}", in("session"));
    expect_says(call(asked + " --camera atlantis"), 2, "there is no camera 'atlantis'");
    expect_says(call(fmt::format("calibrate site {}", in("nowhere"))), 2, "nowhere");
    expect_says(call(asked), 0, "not written");
    const Outcome written = call(asked + " --write");
    expect_says(written, 0, "the file as it was is");
    EXPECT_NE(written.text.find("saw no robot"), std::string::npos) << "two of the three cameras see nothing in four seconds" << written.text;
    const auto after = load_site(in("session/site.yaml"));
    ASSERT_TRUE(after) << after.error().message;
    int calibrated = 0;
    for (std::size_t i = 0; i < after->cameras.size(); ++i) {
        if (!std::holds_alternative<KnownPose>(after->cameras[i].placement)) continue;
        ++calibrated;
        EXPECT_LT(floor_error(*fixed_view(after->cameras[i])), floor_error(*fixed_view(before->cameras[i])));
    }
    EXPECT_GE(calibrated, 1);
    expect_says(call(fmt::format("calibrate site {}", in("session")) + " --camera hall3"), 1, "nothing was learned");
}

}  // namespace
}  // namespace roomfix
