#include "roomfix/calibrate/lens_start.hpp"

#include <numbers>

#include "roomfix/geometry/floor_points.hpp"

namespace roomfix {

std::optional<BoardPose> pose_of_board(const CameraModel& camera, const BoardShot& shot, const Chessboard& board) {
    constexpr double focal = 1000;  // px of a camera that is only imagined: it is turned towards the board
    std::vector<Eigen::Vector3d> rays;
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (const Eigen::Vector2d& corner : shot.corners) {
        const auto ray = unproject(camera, corner);
        if (!ray) return std::nullopt;
        rays.push_back(ray->homogeneous().normalized());
        middle += rays.back();
    }
    const Eigen::Quaterniond turn = Eigen::Quaterniond::FromTwoVectors(middle, Eigen::Vector3d::UnitZ());
    std::vector<FloorPoint> points;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const Eigen::Vector3d ray = turn * rays[i];
        if (!(ray.z() > 0)) return std::nullopt;
        const Eigen::Vector2d at = board.corner(shot.number(i));
        // The board is a floor seen from above: its y runs up there.
        points.push_back({focal * ray.head<2>() / ray.z(), {at.x(), -at.y()}});
    }
    const auto pose = camera_pose_from_floor_points(make_camera_model(1, 1, focal, focal, 0, 0), points, 1);
    if (!pose) return std::nullopt;
    const Eigen::Isometry3d floor_from_board(Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX()));
    BoardPose found{Eigen::Isometry3d(turn.inverse()) * pose->map_from_camera.pose.inverse() * floor_from_board};
    for (std::size_t i = 0; i < shot.corners.size(); ++i) {
        Eigen::Vector3d at = Eigen::Vector3d::Zero();
        at.head<2>() = board.corner(shot.number(i));
        const auto pixel = project(camera, found.camera_from_board * at);
        if (!pixel) return std::nullopt;
        found.squares += (*pixel - shot.corners[i]).squaredNorm();
    }
    return found;
}

LensStart start_of_lens(const std::vector<const BoardShot*>& shots, int width, int height, const Chessboard& board, Distortion kind) {
    constexpr double shortest = 0.15, longest = 6, step = 1.1;  // of the picture's width
    LensStart best;
    int most = -1;
    double least = 0;
    for (double focal = shortest * width; focal < longest * width; focal *= step) {
        LensStart tried;
        tried.model = make_camera_model(width, height, focal, focal, 0.5 * (width - 1), 0.5 * (height - 1), {}, kind);
        int explained = 0;
        double squares = 0;
        for (const BoardShot* shot : shots) {
            const auto pose = pose_of_board(tried.model, *shot, board);
            tried.camera_from_board.push_back(pose ? std::optional(pose->camera_from_board) : std::nullopt);
            if (!pose) continue;
            ++explained;
            squares += pose->squares;
        }
        if (explained < most || (explained == most && squares >= least)) continue;
        most = explained;
        least = squares;
        best = std::move(tried);
    }
    return best;
}

}  // namespace roomfix
