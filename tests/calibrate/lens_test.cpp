#include "roomfix/calibrate/lens.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <memory>
#include <opencv2/calib3d.hpp>
#include <optional>
#include <set>

#include "roomfix/base/decompositions.hpp"
#include "roomfix/calibrate/lens_report.hpp"
#include "roomfix/evaluate/simulated_boards.hpp"
#include "roomfix/simulate/plane_picture.hpp"

namespace roomfix {
namespace {

const Chessboard board{9, 6, 0.025};
const Eigen::Vector2d board_size(8 * 0.025, 5 * 0.025);

CameraModel lens_camera() { return make_camera_model(640, 480, 533, 535, 327, 235, {-0.28, 0.08, 0.001, -0.0006, 0.01}); }

CameraModel camera_of(Distortion kind) {
    switch (kind) {
        case Distortion::plumb_bob:
            return lens_camera();
        case Distortion::rational_polynomial:
            return make_camera_model(640, 480, 400, 401, 322, 238, {0.4, 0.1, 0.001, -0.0006, 0.01, 0.7, 0.2, 0.02}, kind);
        case Distortion::equidistant:
            return make_camera_model(640, 480, 290, 291, 318, 243, {-0.02, 0.01, -0.004, 0.001}, kind);
    }
    return {};
}

std::vector<BoardShot> simulated_shots(const CameraModel& camera, int count, double noise, Random& random) {
    return seen_boards(camera, PrintedBoard(board), standing_still, count, noise, random);
}

double nees_of(const LensCalibration& lens, const CameraModel& truth) {
    const int count = truth.intrinsics_count();
    const Eigen::VectorXd off = (lens.model.intrinsics() - truth.intrinsics()).head(count);
    return off.dot(lens.covariance.topLeftCorner(count, count).ldlt().solve(off));
}

class Lens : public ::testing::TestWithParam<Distortion> {};

TEST_P(Lens, TrueNumbersLieInsideTheStatedIntervals) {
    // 95 % intervals of 8 to 12 numbers in 12 runs, correlated within a run: below 85 % is a false alarm in about 1e-3. Boards are exact.
    Random random(5 + static_cast<std::uint64_t>(GetParam()));
    const CameraModel camera = camera_of(GetParam());
    constexpr int runs = 12;
    int inside = 0, all = 0;
    double squares = 0;
    for (int run = 0; run < runs; ++run) {
        const auto lens = calibrate_lens(simulated_shots(camera, 15, 0.1, random), 640, 480, board, {.kind = GetParam()});
        ASSERT_TRUE(lens) << lens.error().message;
        const IntrinsicsVector off = lens->model.intrinsics() - camera.intrinsics();
        const int count = camera.intrinsics_count();
        for (int i = 0; i < count; ++i) inside += std::abs(off[i]) < 1.96 * std::sqrt(lens->covariance(i, i));
        all += count;
        squares += nees_of(*lens, camera) / count;
        EXPECT_NEAR(lens->sigma, 0.1, 0.015);
        EXPECT_GE(lens->used(), 14) << "one may show the board where another does, by chance\n" << text_of(*lens);
    }
    EXPECT_GT(static_cast<double>(inside) / all, 0.85) << inside << " of " << all;
    // Numbers of the rational lens are known together only along a curve, which no covariance describes: each alone, and the rays are.
    if (GetParam() == Distortion::rational_polynomial) return;
    EXPECT_NEAR(squares / runs, 1, 0.5);
}

TEST_P(Lens, PredictsHowFarRaysAreOff) {
    // The mean square of real errors over the picture, against what the covariance says: in the middle of many runs, since a rational lens
    // now and then has a pole at the picture's rim.
    Random random(9);
    const CameraModel camera = camera_of(GetParam());
    const auto pixels = spread_pixels(camera);
    std::vector<double> ratios;
    for (int run = 0; run < 10; ++run) {
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
    std::nth_element(ratios.begin(), ratios.begin() + 5, ratios.end());
    EXPECT_GT(ratios[5], GetParam() == Distortion::rational_polynomial ? 0.05 : 0.3);  // its rim is better known than a straight line says
    EXPECT_LT(ratios[5], 2);
}

INSTANTIATE_TEST_SUITE_P(EachKind, Lens, ::testing::Values(Distortion::plumb_bob, Distortion::rational_polynomial, Distortion::equidistant));

TEST(CalibrateLens, FindsRenderedCamerasAsWellAsItSays) {
    const CameraModel camera = lens_camera();
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
        nees += nees_of(*lens, camera) / runs;
        last = *lens;
    }
    EXPECT_LT(nees, 17.5) << "nine unknowns, four cameras: four standard deviations above nine";
    EXPECT_NE(text_of(*last).find("fx"), std::string::npos);
    EXPECT_NE(html_of(*last, board, "a < b").find("a &lt; b"), std::string::npos);
}

TEST(CalibrateLens, MeasuresTheBoardAlongWithTheLens) {
    Random random(51);
    const CameraModel camera = lens_camera();
    double nees = 0, nees_as_if_exact = 0, off = 0, off_as_if_exact = 0, board_squares = 0;
    constexpr int runs = 12;
    for (int run = 0; run < runs; ++run) {
        const PrintedBoard glued = glued_board(board, random);
        const std::vector<BoardShot> shots = seen_boards(camera, glued, in_a_hand, 14, 0.05, random);
        const auto lens = calibrate_lens(shots, 640, 480, board);
        const auto exact = calibrate_lens(shots, 640, 480, board, {.exact_board = true, .outlier = 100});
        ASSERT_TRUE(lens && exact) << lens.error().message;
        nees += nees_of(*lens, camera) / runs;
        off += std::abs(lens->model.fx - camera.fx) / runs;
        off_as_if_exact += std::abs(exact->model.fx - camera.fx) / runs;
        EXPECT_NEAR(lens->sigma, 0.05, 0.01);
        EXPECT_GT(exact->sigma, 1.4 * lens->sigma);
        EXPECT_GT(exact->focal_sigma_by_board, 1) << "px: the shots show that the board is not exact";
        nees_as_if_exact += nees_of(*exact, camera) / runs;
        // Where the board is in its own frame is anybody's guess, and so is its scale: compared is what a similarity leaves.
        Eigen::Matrix3Xd truth(3, board.corners()), found(3, board.corners());
        for (int i = 0; i < board.corners(); ++i) truth.col(i) = glued.corner(i), found.col(i) = lens->board.corner(i);
        const Eigen::Matrix4d moved = Eigen::umeyama(found, truth, true);
        board_squares += ((moved.topLeftCorner<3, 3>() * found).colwise() + moved.topRightCorner<3, 1>() - truth).squaredNorm() / (board.corners() * runs);
    }
    EXPECT_LT(nees, 14) << "nine unknowns, twelve cameras: four standard deviations above nine";
    EXPECT_GT(nees, 4);
    EXPECT_LT(nees_as_if_exact, 14) << "it says so where the board is not exact";
    EXPECT_LT(off, 0.2 * off_as_if_exact) << "px, of the focal length";
    EXPECT_LT(std::sqrt(board_squares), 5e-5) << "m";
}

TEST(CalibrateLens, ABoardThatMayBendExplainsNoWrongLens) {
    // Boards like these, before pixels that are not square, made a first fit bend the board instead of moving the lens.
    const std::vector<Vector6d> poses = {
        // of the board in the camera: m, rad (Rodrigues)
        {-0.061, -0.136, 0.5, -0.025, 0.075, 1.257},  {-0.336, 0.005, 0.506, 1.108, -0.842, -1.228}, {0.204, 0.062, 0.62, -0.633, 0.543, -1.55},
        {0.229, 0.068, 0.606, -0.758, 0.463, -2.905}, {-0.006, -0.117, 0.71, -0.401, -0.674, 2.759}, {0.185, -0.153, 0.466, 0.292, 0.296, 1.591},
        {0.257, 0.12, 0.724, -0.08, 0.032, -1.677},   {-0.066, -0.105, 0.483, -0.381, -0.04, 1.598}, {0.026, 0.016, 0.593, -0.749, -0.082, 2.849},
        {0.153, 0.093, 0.544, 1.052, -0.34, 2.858},   {0.061, 0.002, 0.361, -0.562, 0.17, 2.852},    {0.211, -0.037, 0.368, 0.212, 0.31, 2.724},
        {-0.119, 0.071, 0.68, 0.176, 0.009, -1.472},  {0.161, -0.039, 0.579, 0.19, 0.104, 1.467},    {-0.099, 0.104, 0.375, 0.537, 0.073, -1.445}};
    const CameraModel camera = make_camera_model(640, 480, 491, 588, 320, 255, {-0.255, 0.086, 0.001, -0.0006, 0.01});
    Random random(2);
    for (int run = 0; run < 4; ++run) {
        std::vector<BoardShot> shots;
        for (const Vector6d& pose : poses) {
            BoardShot shot{.name = fmt::format("shot {}", shots.size()), .corners = {}, .edge_width = 2, .square_pixels = 30, .refused = {}};
            const Eigen::Isometry3d camera_from_board =
                Eigen::Translation3d(pose.head<3>()) * Eigen::AngleAxisd(pose.tail<3>().norm(), pose.tail<3>().normalized());
            for (int i = 0; i < board.corners(); ++i) {
                const Eigen::Vector2d noise(random.normal(0.1), random.normal(0.1));
                shot.corners.push_back(seen_corner(camera, camera_from_board, {PrintedBoard(board)}, i) + noise);
            }
            shots.push_back(shot);
        }
        const auto lens = calibrate_lens(shots, 640, 480, board);
        ASSERT_TRUE(lens) << lens.error().message;
        EXPECT_NEAR(lens->model.fx, camera.fx, 5) << run;
        EXPECT_NEAR(lens->model.fy, camera.fy, 6) << run;
    }
}

TEST(CalibrateLens, WhatNoMotionExplainsMakesTheNumbersLessSure) {
    Random random(52);
    const CameraModel camera = lens_camera();
    double shaking = 0, still = 0;
    constexpr int runs = 6;
    for (int run = 0; run < runs; ++run) {
        std::vector<BoardShot> shots = simulated_shots(camera, 14, 0.02, random);
        still += calibrate_lens(shots, 640, 480, board)->disagreement / runs;
        for (BoardShot& shot : shots) {  // to and fro while its rows are read out
            const double begins = random.uniform(0, 6.28), far = random.normal(0.3);
            for (Eigen::Vector2d& corner : shot.corners) corner.x() += far * std::sin(begins + corner.y() / 40);
        }
        const auto lens = calibrate_lens(shots, 640, 480, board, {.outlier = 100});
        ASSERT_TRUE(lens) << lens.error().message;
        shaking += lens->disagreement / runs;
    }
    EXPECT_LT(still, 1.5);
    EXPECT_GT(shaking, 2);
}

TEST(CalibrateLens, ABoardThatMovesIsMeasuredAsItMoves) {
    Random random(77);
    const CameraModel camera = lens_camera();
    double nees = 0, off = 0, off_if_still = 0, shift = 0;
    constexpr int runs = 12;
    for (int run = 0; run < runs; ++run) {
        const auto shots = seen_boards(camera, PrintedBoard(board), {.shift = 3e-4, .turn = 8e-4}, 14, 0.03, random);
        const auto lens = calibrate_lens(shots, 640, 480, board, {.outlier = 100});
        const auto if_still = calibrate_lens(shots, 640, 480, board, {.exact_board = true, .outlier = 100});
        ASSERT_TRUE(lens && if_still) << lens.error().message;
        nees += nees_of(*lens, camera) / 9 / runs;
        shift += lens->shift / runs;
        off += std::pow(lens->model.fx - camera.fx, 2);
        off_if_still += std::pow(if_still->model.fx - camera.fx, 2);
    }
    EXPECT_LT(nees, 2.2);
    EXPECT_LT(off, 0.8 * off_if_still);
    EXPECT_NEAR(shift, 3e-4 * std::sqrt(3), 2.5e-4) << "m; what is expected of boards that nobody knows pulls it down";
}

TEST(CalibrateLens, IsNoWorseThanOpenCVOnTheSameCorners) {
    Random random(7);
    const auto shots = simulated_shots(lens_camera(), 12, 0.2, random);
    const auto lens = calibrate_lens(shots, 640, 480, board, {.exact_board = true});  // as OpenCV takes it
    ASSERT_TRUE(lens);
    EXPECT_LT(lens->focal_sigma_by_board, 0.5 * std::sqrt(lens->covariance(0, 0))) << "this board is exact";
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
    auto shots = simulated_shots(lens_camera(), 8, 0.1, random);
    shots[2].edge_width = 9;
    shots.push_back(shots[4]);
    shots.back().name = "again";
    shots.back().edge_width = 3;
    shots.push_back(shots[0]);  // the board in a mirror, its corners counted as if it were not
    for (int row = 0; row < board.rows; ++row) {
        for (int column = 0; column < board.columns; ++column) {
            shots.back().corners[static_cast<std::size_t>(row * board.columns + column)] =
                shots[0].corners[static_cast<std::size_t>((row + 1) * board.columns - 1 - column)];
        }
    }
    for (auto& c : shots[5].corners) c += Eigen::Vector2d(random.normal(3), random.normal(3));  // bent
    const auto lens = calibrate_lens(shots, 640, 480, board);
    ASSERT_TRUE(lens) << lens.error().message;
    EXPECT_NE(lens->shots[2].refused.find("blurred"), std::string::npos);
    EXPECT_NE(lens->shots[5].refused.find("corners are off"), std::string::npos) << lens->shots[5].refused;
    EXPECT_NE(lens->shots[8].refused.find("where shot 4 does"), std::string::npos);
    EXPECT_NE(lens->shots[9].refused.find("mirrored"), std::string::npos) << lens->shots[9].refused;
    EXPECT_EQ(lens->used(), 6);
    EXPECT_NE(text_of(*lens).find("not used: shot 2: blurred"), std::string::npos);
}

TEST(CalibrateLens, IsTheSameWhereverItsNumbersLieInMemory) {
    Random random(17);
    const auto shots = simulated_shots(lens_camera(), 40, 0.1, random);
    std::vector<std::unique_ptr<char[]>> between;
    std::set<double> focal_lengths;
    for (int run = 0; run < 5; ++run) {
        between.push_back(std::make_unique<char[]>(20));  // takes 32 bytes: what comes next is half a cache line farther
        const auto lens = calibrate_lens(shots, 640, 480, board);
        ASSERT_TRUE(lens) << lens.error().message;
        focal_lengths.insert(lens->model.fx);
    }
    EXPECT_EQ(focal_lengths.size(), 1U);
}

TEST(CalibrateLens, SaysWhatIsMissing) {
    Random random(15);
    const auto expect_error = [](const std::vector<BoardShot>& shots, const char* words) {
        const auto lens = calibrate_lens(shots, 640, 480, board);
        ASSERT_FALSE(lens);
        EXPECT_NE(lens.error().message.find(words), std::string::npos) << lens.error().message;
    };
    expect_error({}, "no picture shows a board");
    auto shots = simulated_shots(lens_camera(), 8, 0.1, random);
    for (auto& s : shots) s.corners = shots[0].corners;
    expect_error(shots, "shows the board where");
    // All parallel to the picture: distance and focal length cannot be told apart.
    std::vector<BoardShot> flat;
    for (int i = 0; i < 8; ++i) {
        BoardShot shot = shots[0];
        shot.corners.clear();
        for (int k = 0; k < board.corners(); ++k) {
            const Eigen::Vector2d at = board.corner(k);
            shot.corners.push_back(*project(lens_camera(), {at.x() - 0.2 + 0.03 * i, at.y() - 0.1 + 0.01 * i, 0.5}) +
                                   Eigen::Vector2d(random.normal(0.1), random.normal(0.1)));
        }
        flat.push_back(shot);
    }
    expect_error(flat, "focal length");
}

TEST(Chessboard, CornersThatCannotBeReadAreLeftOut) {
    Random random(19);
    PlanePictures pictures(lens_camera(), {}, 5);
    LumaImage picture;
    Eigen::Isometry3d pose(Eigen::AngleAxisd(0.4, Eigen::Vector3d(1, 2, 0).normalized()));
    pose.translation() << -0.1, -0.06, 0.35;
    pictures.render(chessboard_pattern(board.columns, board.rows, board.square), pose, 0, picture);
    ASSERT_EQ(find_chessboard(picture, board, "clean").numbers.size(), 0U) << "all are there";
    constexpr int hidden = 53;  // the last
    const Eigen::Vector2d at = *project(lens_camera(), pose * Eigen::Vector3d(board.corner(hidden).x(), board.corner(hidden).y(), 0));
    for (int y = -8; y <= 8; ++y) {  // worn off: speckled, but still a corner to a detector that looks at the squares
        for (int x = -8; x <= 8; ++x) {
            std::uint8_t& pixel = picture.row(static_cast<int>(at.y()) + y)[static_cast<int>(at.x()) + x];
            pixel = static_cast<std::uint8_t>(std::clamp(128 + 0.3 * (pixel - 128) + random.normal(40), 0.0, 255.0));
        }
    }
    const BoardShot shot = find_chessboard(picture, board, "worn");
    EXPECT_TRUE(shot.refused.empty()) << shot.refused;
    ASSERT_EQ(shot.corners.size(), 53U);
    for (std::size_t i = 0; i < shot.corners.size(); ++i) EXPECT_EQ(shot.number(i), static_cast<int>(i));
}

TEST(Chessboard, APhotographedBoardShowsItsCornersWhereTheyWerePrinted) {
    Random random(23);
    const CameraModel camera = lens_camera();
    PlanePictures pictures(camera, {}, 6);
    PrintedBoard made = glued_board(board, random);
    made.shape[0] = 0.02;  // 2 mm at its ends
    double squares = 0, as_if_flat = 0, count = 0;
    LumaImage picture;
    for (const Eigen::Isometry3d& pose : board_poses(camera, board_size, 6, random)) {
        const ShownBoard here = shown(made, {.shift = 5e-4, .turn = 1e-3}, random);
        photograph(pictures, pattern_of(board), here, pose, 0, picture);
        const BoardShot shot = find_chessboard(picture, board, "bent and moved");
        ASSERT_TRUE(shot.refused.empty()) << shot.refused;
        for (std::size_t i = 0; i < shot.corners.size(); ++i) {
            const int number = shot.number(i);
            const Eigen::Vector2d flat = board.corner(number);
            squares += (shot.corners[i] - seen_corner(camera, pose, here, number)).squaredNorm();
            as_if_flat += (shot.corners[i] - *project(camera, pose * Eigen::Vector3d(flat.x(), flat.y(), 0))).squaredNorm();
            ++count;
        }
    }
    EXPECT_LT(std::sqrt(squares / count), 0.05);
    EXPECT_GT(std::sqrt(as_if_flat / count), 0.3);
}

TEST(Chessboard, ABoardOfAnotherSizeIsNamed) {
    Random random(17);
    PlanePictures pictures(lens_camera(), {}, 3);
    LumaImage picture;
    pictures.render(chessboard_pattern(8, 6, 0.025), board_poses(lens_camera(), board_size, 1, random)[0], 0, picture);
    EXPECT_FALSE(find_chessboard(picture, board, "a").refused.empty());
    const auto other = other_board_in(picture, board);
    ASSERT_TRUE(other);
    EXPECT_EQ(other->columns * 100 + other->rows, 806);
    EXPECT_NE(board_svg(board).find("9 x 6 inner corners, squares of 25 mm"), std::string::npos);
}

}  // namespace
}  // namespace roomfix
