#include "roomfix/calibrate/lens.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <opencv2/calib3d.hpp>
#include <optional>

#include "roomfix/calibrate/lens_report.hpp"
#include "roomfix/simulate/plane_picture.hpp"

namespace roomfix {
namespace {

const Chessboard board{9, 6, 0.025};
const Eigen::Vector2d board_size(8 * 0.025, 5 * 0.025);

CameraModel plain_camera() { return make_camera_model(640, 480, 533, 535, 327, 235, {-0.28, 0.08, 0.001, -0.0006, 0.01}); }

CameraModel camera_of(Distortion kind) {
    switch (kind) {
        case Distortion::plumb_bob:
            return plain_camera();
        case Distortion::rational_polynomial:
            return make_camera_model(640, 480, 400, 401, 322, 238, {0.4, 0.1, 0.001, -0.0006, 0.01, 0.7, 0.2, 0.02}, kind);
        case Distortion::equidistant:
            return make_camera_model(640, 480, 290, 291, 318, 243, {-0.02, 0.01, -0.004, 0.001}, kind);
    }
    return {};
}

/// Shots straight from geometry, with noise on each corner.
std::vector<BoardShot> simulated_shots(const CameraModel& camera, int count, double noise, Random& random) {
    std::vector<BoardShot> shots;
    for (const Eigen::Isometry3d& pose : board_poses(camera, board_size, count, random)) {
        BoardShot shot;
        shot.name = "shot " + std::to_string(shots.size());
        shot.edge_width = 2;
        shot.square_pixels = 30;
        for (int i = 0; i < board.corners(); ++i) {
            const Eigen::Vector2d at = board.corner(i);
            shot.corners.push_back(*project(camera, pose * Eigen::Vector3d(at.x(), at.y(), 0)) + Eigen::Vector2d(random.normal(noise), random.normal(noise)));
        }
        shots.push_back(shot);
    }
    return shots;
}

class Lens : public ::testing::TestWithParam<Distortion> {};

TEST_P(Lens, TrueNumbersLieInsideTheStatedIntervals) {
    // 95 % intervals of 8 to 12 numbers in 40 runs, correlated within a run: below 90 % is a false alarm in about 1e-3.
    Random random(5 + static_cast<std::uint64_t>(GetParam()));
    const CameraModel camera = camera_of(GetParam());
    constexpr int runs = 40;
    int inside = 0, all = 0;
    double squares = 0;
    for (int run = 0; run < runs; ++run) {
        const auto lens = calibrate_lens(simulated_shots(camera, 15, 0.1, random), 640, 480, board, {.kind = GetParam()});
        ASSERT_TRUE(lens) << lens.error().message;
        const IntrinsicsVector off = lens->model.intrinsics() - camera.intrinsics();
        const int count = camera.intrinsics_count();
        for (int i = 0; i < count; ++i) inside += std::abs(off[i]) < 1.96 * std::sqrt(lens->covariance(i, i));
        all += count;
        squares += off.head(count).dot(lens->covariance.topLeftCorner(count, count).ldlt().solve(off.head(count))) / count;
        EXPECT_NEAR(lens->sigma, 0.1, 0.015);
    }
    EXPECT_GT(static_cast<double>(inside) / all, 0.90) << inside << " of " << all;
    // Numbers of the rational lens are known together only along a curve, which no covariance describes: each alone, and the rays are.
    if (GetParam() == Distortion::rational_polynomial) return;
    EXPECT_NEAR(squares / runs, 1, 0.35);
}
TEST_P(Lens, PredictsHowFarRaysAreOff) {
    // The mean square of real errors over the picture, against what the covariance says: in the middle of many runs, since a rational lens
    // now and then has a pole at the picture's rim.
    Random random(9);
    const CameraModel camera = camera_of(GetParam());
    const auto pixels = spread_pixels(camera);
    std::vector<double> ratios;
    for (int run = 0; run < 20; ++run) {
        const auto lens = calibrate_lens(simulated_shots(camera, 12, 0.1, random), 640, 480, board, {.kind = GetParam()});
        ASSERT_TRUE(lens);
        const double predicted = predicted_error(lens->model, lens->covariance, pixels).squaredNorm();
        // Where the true rays are imaged by the found lens, once it is turned to fit best (small angles, three Gauss-Newton steps).
        Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
        double squares = 0;
        for (int round = 0; round < 3; ++round) {
            Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
            Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
            squares = 0;
            for (Eigen::Index i = 0; i < pixels.cols(); ++i) {
                const Eigen::Vector3d ray = turn * unproject(camera, pixels.col(i))->homogeneous();
                ProjectionJacobian by_point;
                const auto seen = project(lens->model, ray, &by_point);
                if (!seen) continue;  // a corner of the picture where no board was
                const Eigen::Matrix<double, 2, 3> by_turn = -by_point * skew(ray);
                normal += by_turn.transpose() * by_turn;
                gradient += by_turn.transpose() * (pixels.col(i) - *seen);
                squares += (pixels.col(i) - *seen).squaredNorm();
            }
            turn = exponential_rotation(normal.ldlt().solve(gradient)) * turn;
        }
        ratios.push_back(squares / predicted);
    }
    std::nth_element(ratios.begin(), ratios.begin() + 10, ratios.end());
    EXPECT_GT(ratios[10], GetParam() == Distortion::rational_polynomial ? 0.05 : 0.3);  // its rim is better known than a straight line says
    EXPECT_LT(ratios[10], 2);
}

INSTANTIATE_TEST_SUITE_P(EachKind, Lens, ::testing::Values(Distortion::plumb_bob, Distortion::rational_polynomial, Distortion::equidistant));

TEST(CalibrateLens, FindsRenderedCamerasAsWellAsItSays) {
    const CameraModel camera = plain_camera();
    double nees = 0;
    constexpr int runs = 4;
    std::optional<LensCalibration> last;
    for (int run = 0; run < runs; ++run) {
        Random random(31 + static_cast<std::uint64_t>(run));
        PlanePictures pictures(camera, {}, 41 + static_cast<std::uint64_t>(run));
        std::vector<BoardShot> shots;
        LumaImage picture;
        for (const Eigen::Isometry3d& pose : board_poses(camera, board_size, 14, random)) {
            pictures.render(chessboard_pattern(board.columns, board.rows, board.square), pose, shots.size(), picture);
            shots.push_back(find_chessboard(picture, board, "shot"));
            ASSERT_TRUE(shots.back().refused.empty()) << shots.size();
        }
        const auto lens = calibrate_lens(shots, 640, 480, board);
        ASSERT_TRUE(lens) << lens.error().message;
        EXPECT_LT(lens->sigma, 0.03) << "px: OpenCV's corners are at 0.05";
        const Eigen::Matrix<double, 9, 1> off = (lens->model.intrinsics() - camera.intrinsics()).head<9>();
        nees += off.dot(lens->covariance.topLeftCorner<9, 9>().ldlt().solve(off)) / runs;
        last = *lens;
    }
    EXPECT_LT(nees, 17.5) << "nine unknowns, four cameras: four standard deviations above nine";
    EXPECT_NE(text_of(*last).find("fx"), std::string::npos);
    EXPECT_NE(html_of(*last, board, "a < b").find("a &lt; b"), std::string::npos);
}

TEST(CalibrateLens, ABoardThatBendsMakesTheNumbersLessSure) {
    Random random(51);
    const CameraModel camera = plain_camera();
    double as_stated = 0, as_if_flat = 0, straight = 0;
    constexpr int runs = 12;
    for (int run = 0; run < runs; ++run) {
        std::vector<BoardShot> shots = simulated_shots(camera, 14, 0.02, random);
        straight += calibrate_lens(shots, 640, 480, board)->disagreement / runs;
        shots.clear();
        for (const Eigen::Isometry3d& pose : board_poses(camera, board_size, 14, random)) {
            BoardShot shot{"bent", {}, 2, 30, ""};
            const double bend = random.normal(0.06);  // 1/m, another one each time it is held: 0.6 mm at its ends
            for (int i = 0; i < board.corners(); ++i) {
                const Eigen::Vector2d at = board.corner(i);
                const double height = bend * std::pow(at.x() - board_size.x() / 2, 2);
                shot.corners.push_back(*project(camera, pose * Eigen::Vector3d(at.x(), at.y(), height)) +
                                       Eigen::Vector2d(random.normal(0.02), random.normal(0.02)));
            }
            shots.push_back(shot);
        }
        const auto lens = calibrate_lens(shots, 640, 480, board, {.outlier = 100});
        ASSERT_TRUE(lens) << lens.error().message;
        const Eigen::Matrix<double, 9, 1> off = (lens->model.intrinsics() - camera.intrinsics()).head<9>();
        const double nees = off.dot(lens->covariance.topLeftCorner<9, 9>().ldlt().solve(off));
        as_stated += nees / runs;
        as_if_flat += nees * lens->disagreement / runs;
    }
    EXPECT_LT(straight, 1.2);
    EXPECT_GT(as_if_flat, 2 * as_stated);
    // Bent boards also pull all shots the same way, which no scatter among them shows.
    EXPECT_LT(as_stated, 3 * 9) << "nine unknowns";
}

TEST(CalibrateLens, IsNoWorseThanOpenCVOnTheSameCorners) {
    Random random(7);
    const auto shots = simulated_shots(plain_camera(), 12, 0.2, random);
    const auto lens = calibrate_lens(shots, 640, 480, board);
    ASSERT_TRUE(lens);
    std::vector<std::vector<cv::Point3f>> places;
    std::vector<std::vector<cv::Point2f>> pixels;
    for (const BoardShot& shot : lens->shots) {
        if (!shot.refused.empty()) continue;
        places.emplace_back();
        pixels.emplace_back();
        for (int i = 0; i < board.corners(); ++i) {
            const Eigen::Vector2f at = board.corner(i).cast<float>(), pixel = shot.corners[static_cast<std::size_t>(i)].cast<float>();
            places.back().emplace_back(at.x(), at.y(), 0.F);
            pixels.back().emplace_back(pixel.x(), pixel.y());
        }
    }
    cv::Mat matrix, distortion;
    std::vector<cv::Mat> rotations, translations;
    const double rms = cv::calibrateCamera(places, pixels, {640, 480}, matrix, distortion, rotations, translations);
    EXPECT_LE(lens->rms, rms * 1.0001);
    EXPECT_NEAR(matrix.at<double>(0, 0), lens->model.fx, 2 * std::sqrt(lens->covariance(0, 0)));
}

TEST(CalibrateLens, RefusesPoorShotsAndSaysWhich) {
    Random random(13);
    auto shots = simulated_shots(plain_camera(), 8, 0.1, random);
    shots[2].edge_width = 9;
    shots.push_back(shots[4]);
    shots.back().name = "again";
    shots.back().edge_width = 3;
    for (auto& c : shots[5].corners) c += Eigen::Vector2d(random.normal(3), random.normal(3));  // bent
    const auto lens = calibrate_lens(shots, 640, 480, board);
    ASSERT_TRUE(lens) << lens.error().message;
    EXPECT_NE(lens->shots[2].refused.find("blurred"), std::string::npos);
    EXPECT_NE(lens->shots[5].refused.find("corners are off"), std::string::npos) << lens->shots[5].refused;
    EXPECT_NE(lens->shots[8].refused.find("where shot 4 does"), std::string::npos);
    EXPECT_EQ(lens->used(), 6);
    EXPECT_NE(text_of(*lens).find("not used: shot 2: blurred"), std::string::npos);
}

TEST(CalibrateLens, SaysWhatIsMissing) {
    Random random(15);
    const auto expect_error = [](const std::vector<BoardShot>& shots, const char* words) {
        const auto lens = calibrate_lens(shots, 640, 480, board);
        ASSERT_FALSE(lens);
        EXPECT_NE(lens.error().message.find(words), std::string::npos) << lens.error().message;
    };
    expect_error({}, "no picture shows a board");
    auto shots = simulated_shots(plain_camera(), 8, 0.1, random);
    for (auto& s : shots) s.corners = shots[0].corners;
    expect_error(shots, "shows the board where");
    // All parallel to the picture: distance and focal length cannot be told apart.
    std::vector<BoardShot> flat;
    for (int i = 0; i < 8; ++i) {
        BoardShot shot = shots[0];
        shot.corners.clear();
        for (int k = 0; k < board.corners(); ++k) {
            const Eigen::Vector2d at = board.corner(k);
            shot.corners.push_back(*project(plain_camera(), {at.x() - 0.2 + 0.03 * i, at.y() - 0.1 + 0.01 * i, 0.5}) +
                                   Eigen::Vector2d(random.normal(0.1), random.normal(0.1)));
        }
        flat.push_back(shot);
    }
    expect_error(flat, "focal length");
}

TEST(Chessboard, ABoardOfAnotherSizeIsNamed) {
    Random random(17);
    PlanePictures pictures(plain_camera(), {}, 3);
    LumaImage picture;
    pictures.render(chessboard_pattern(8, 6, 0.025), board_poses(plain_camera(), board_size, 1, random)[0], 0, picture);
    EXPECT_FALSE(find_chessboard(picture, board, "a").refused.empty());
    const auto other = other_board_in(picture, board);
    ASSERT_TRUE(other);
    EXPECT_EQ(other->columns * 100 + other->rows, 806);
    EXPECT_NE(board_svg(board).find("9 x 6 inner corners, squares of 25 mm"), std::string::npos);
}

}  // namespace
}  // namespace roomfix
