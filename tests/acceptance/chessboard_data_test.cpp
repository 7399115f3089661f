// Real pictures of a chessboard (OpenCV's samples). Looked for in $ROOMFIX_DATA/chessboard and ../shared/data/chessboard beside the checkout.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "roomfix/calibrate/lens.hpp"
#include "roomfix/calibrate/plumb_line.hpp"
#include "roomfix/connect/camera_info.hpp"
#include "roomfix/imaging/load_luma.hpp"

namespace roomfix {
namespace {

namespace fs = std::filesystem;

fs::path data_folder() {
    const char* from_user = std::getenv("ROOMFIX_DATA");
    return (from_user ? fs::path(from_user) : fs::path(ROOMFIX_SOURCE) / "../shared/data") / "chessboard";
}

TEST(ChessboardData, BothCamerasAreCalibratedBetterThanThePublishedResult) {
    if (!fs::exists(data_folder())) GTEST_SKIP() << data_folder() << " is absent: set ROOMFIX_DATA to a folder that holds chessboard/";
    const Chessboard board{9, 6, 0.025};
    for (const std::string side : {"left", "right"}) {
        std::vector<BoardShot> shots;
        for (const auto& entry : fs::directory_iterator(data_folder())) {
            if (entry.path().extension() != ".jpg" || entry.path().filename().string().rfind(side, 0) != 0) continue;
            const auto picture = load_luma(entry.path());
            ASSERT_TRUE(picture);
            shots.push_back(find_chessboard(*picture, board, entry.path().filename().string()));
        }
        const auto lens = calibrate_lens(shots, 640, 480, board);
        ASSERT_TRUE(lens) << lens.error().message;
        EXPECT_EQ(lens->used(), 13);
        EXPECT_LT(lens->rms, 0.3);
        if (side == "right") continue;
        const auto published = load_camera_info(data_folder() / "left_intrinsics.yml");
        ASSERT_TRUE(published) << published.error().message;
        EXPECT_LT(lens->rms, 0.3926) << "average reprojection error of the published result";
        // That result rests on one shot whose corners are off by 1.2 px: half a percent of the focal length.
        EXPECT_NEAR(lens->model.fx, published->model.fx, 0.006 * published->model.fx);
        EXPECT_NEAR(lens->model.cx, published->model.cx, 2 * std::sqrt(lens->covariance(2, 2)));
    }
}

TEST(ChessboardData, EdgesOfTheRoomTellTheSameDistortion) {
    if (!fs::exists(data_folder())) GTEST_SKIP() << data_folder() << " is absent: set ROOMFIX_DATA to a folder that holds chessboard/";
    // The pictures show a desk with rounded things on it as well: k1 of the boards is -0.283 (left) and -0.292 (right).
    for (const auto& [side, k1] : {std::pair{"left", -0.283}, {"right", -0.292}}) {
        std::vector<LongEdge> edges;
        std::size_t number = 0;
        for (const auto& entry : fs::directory_iterator(data_folder())) {
            if (entry.path().extension() != ".jpg" || entry.path().filename().string().rfind(side, 0) != 0) continue;
            const auto picture = load_luma(entry.path());
            ASSERT_TRUE(picture);
            for (LongEdge& edge : long_edges(*picture, number)) edges.push_back(std::move(edge));
            ++number;
        }
        const auto found = straighten(std::move(edges), make_camera_model(640, 480, 535, 535, 319.5, 239.5));
        ASSERT_TRUE(found) << found.error().message;
        EXPECT_LT(found->rms, 0.3 * found->before);
        EXPECT_NEAR(found->model.distortion[0], k1, 0.05) << side;
    }
}

}  // namespace
}  // namespace roomfix
