#include "roomfix/evaluate/simulated_boards.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "roomfix/calibrate/charuco.hpp"

namespace roomfix {
namespace {

/// By how much a place of a board is off the even and flat one, m; between corners bilinear, outside of them as the nearest four say.
class BoardError {
public:
    explicit BoardError(const PrintedBoard& board) : nominal_(board.nominal) {
        for (int i = 0; i < board.nominal.corners(); ++i) {
            const Eigen::Vector2d flat = board.nominal.corner(i);
            at_corners_.emplace_back(board.corner(i) - Eigen::Vector3d(flat.x(), flat.y(), 0));
        }
    }
    Eigen::Vector3d operator()(const Eigen::Vector2d& place) const {
        const double u = place.x() / nominal_.square, v = place.y() / nominal_.square;
        const auto cell = [](double at, int corners) { return std::clamp(static_cast<int>(std::floor(at)), 0, corners - 2); };
        const int column = cell(u, nominal_.columns), row = cell(v, nominal_.rows);
        const auto corner = [&](int right, int down) { return at_corners_[static_cast<std::size_t>((row + down) * nominal_.columns + column + right)]; };
        const double x = u - column, y = v - row;
        return (1 - y) * ((1 - x) * corner(0, 0) + x * corner(1, 0)) + y * ((1 - x) * corner(0, 1) + x * corner(1, 1));
    }

private:
    Chessboard nominal_;
    std::vector<Eigen::Vector3d> at_corners_;
};

}  // namespace

FlatPattern pattern_of(const Chessboard& board, bool old_layout) {
    const FlatPattern squares = chessboard_pattern(board.columns, board.rows, board.square);
    if (!board.markers) return squares;
    constexpr float black = 0.08F, white = 0.9F;
    std::map<std::pair<int, int>, std::vector<std::vector<bool>>> bits;
    for (const BoardMarker& marker : markers_of(board, old_layout)) bits[{marker.column, marker.row}] = marker_bits(board, marker.number);
    const bool lower_left_black = old_layout && board.rows % 2 == 1;  // the upper left square is white then
    return [=](const Eigen::Vector2d& p) {
        const Eigen::Vector2d at(p.x() / board.square + 1, p.y() / board.square + 1);  // squares
        // Moved by a square along the board, black and white change places.
        const bool on_board = at.x() >= 0 && at.y() >= 0 && at.x() <= board.columns + 1 && at.y() <= board.rows + 1;
        if (!on_board) return squares(p);
        const auto marker = bits.find({static_cast<int>(at.x()), static_cast<int>(at.y())});
        if (marker == bits.end()) return (static_cast<int>(at.x()) + static_cast<int>(at.y())) % 2 == (lower_left_black ? 1 : 0) ? black : white;
        const double side = board.markers->size / board.square, gap = (1 - side) / 2;
        const Eigen::Vector2d own = (at - at.array().floor().matrix() - Eigen::Vector2d(gap, gap)) / side;
        if (own.minCoeff() < 0 || own.maxCoeff() >= 1) return white;
        const auto count = static_cast<double>(marker->second.size());
        return marker->second[static_cast<std::size_t>(own.y() * count)][static_cast<std::size_t>(own.x() * count)] ? white : black;
    };
}

PrintedBoard glued_board(const Chessboard& board, Random& random) {
    PrintedBoard made(board);
    made.shape << random.normal(0.005), random.normal(0.005), random.normal(0.005), random.normal(0.001);
    for (auto corner : made.offsets.colwise()) corner << random.normal(6e-5), random.normal(6e-5), random.normal(4e-5);
    return made;
}

PrintedBoard held_board(PrintedBoard board, double held_bend, Random& random) {
    board.shape.head<3>() += Eigen::Vector3d(random.normal(held_bend), random.normal(held_bend), random.normal(held_bend));
    return board;
}

void photograph(PlanePictures& pictures, const FlatPattern& pattern, const PrintedBoard& board, const Eigen::Isometry3d& camera_from_board, std::uint64_t index,
                LumaImage& picture) {
    const BoardError error(board);
    const auto printed = [&](const Eigen::Vector2d& p) { return pattern(p - error(p).head<2>()); };
    pictures.render(printed, camera_from_board, index, picture, [&](const Eigen::Vector2d& p) { return error(p).z(); });
}

std::vector<BoardShot> seen_boards(const CameraModel& camera, const PrintedBoard& board, double held_bend, int count, double noise, Random& random) {
    std::vector<BoardShot> shots;
    for (const Eigen::Isometry3d& pose : board_poses(camera, board.nominal.corner(board.nominal.corners() - 1), count, random)) {
        BoardShot shot{.name = fmt::format("shot {}", shots.size()), .corners = {}, .edge_width = 2, .square_pixels = 30, .refused = {}};
        const PrintedBoard shown = held_board(board, held_bend, random);
        for (int i = 0; i < board.nominal.corners(); ++i) {
            shot.corners.push_back(*project(camera, pose * shown.corner(i)) + Eigen::Vector2d(random.normal(noise), random.normal(noise)));
        }
        shots.push_back(shot);
    }
    return shots;
}

}  // namespace roomfix
