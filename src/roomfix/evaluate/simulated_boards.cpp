#include "roomfix/evaluate/simulated_boards.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "roomfix/base/random_vector.hpp"
#include "roomfix/calibrate/charuco.hpp"

namespace roomfix {
namespace {

/// Weights of four values, one step apart, at `x` (0 to 1) between the middle two: a cubic through these that has no kinks (Catmull and Rom 1974).
Eigen::Vector4d smooth_weights(double x) {
    return 0.5 * Eigen::Vector4d(((2 - x) * x - 1) * x, (3 * x - 5) * x * x + 2, ((4 - 3 * x) * x + 1) * x, (x - 1) * x * x);
}

/// By how much a place of a board is off the even and flat one, m. Smooth between the corners: paper has no kinks there. Tabulated.
class BoardError {
public:
    explicit BoardError(const PrintedBoard& board) : square_(board.nominal.square), columns_(board.nominal.columns), rows_(board.nominal.rows) {
        for (int row = 0; row <= fine * (rows_ + 2 * margin); ++row) {
            for (int column = 0; column <= fine * (columns_ + 2 * margin); ++column) {
                table_.push_back(between_corners(board, static_cast<double>(column) / fine - margin, static_cast<double>(row) / fine - margin));
            }
        }
    }
    Eigen::Vector3d operator()(const Eigen::Vector2d& place) const {
        const auto in_table = [&](double at, int corners) { return std::clamp(fine * (at / square_ + margin), 0.0, fine * (corners + 2 * margin) - 1.0); };
        const double u = in_table(place.x(), columns_), v = in_table(place.y(), rows_);
        const int column = static_cast<int>(u), row = static_cast<int>(v), stride = fine * (columns_ + 2 * margin) + 1;
        const auto at = [&](int right, int down) { return table_[static_cast<std::size_t>((row + down) * stride + column + right)]; };
        const double x = u - column, y = v - row;
        return (1 - y) * ((1 - x) * at(0, 0) + x * at(1, 0)) + y * ((1 - x) * at(0, 1) + x * at(1, 1));
    }

private:
    static constexpr int fine = 8;    // places for each square
    static constexpr int margin = 2;  // squares around the outer corners

    /// At a place in squares from the first corner.
    static Eigen::Vector3d between_corners(const PrintedBoard& board, double u, double v) {
        const int column = static_cast<int>(std::floor(u)), row = static_cast<int>(std::floor(v));
        const Eigen::Vector4d across = smooth_weights(u - column), down = smooth_weights(v - row);
        Eigen::Vector3d sum = Eigen::Vector3d::Zero();
        for (int j = 0; j < 4; ++j) {
            for (int i = 0; i < 4; ++i) sum += across[i] * down[j] * at_corner(board, column + i - 1, row + j - 1);
        }
        return sum;
    }
    /// Outside of the board it goes on as its last two corners say.
    static Eigen::Vector3d at_corner(const PrintedBoard& board, int column, int row) {
        const Chessboard& nominal = board.nominal;
        const int last_column = nominal.columns - 1, last_row = nominal.rows - 1;
        if (column < 0) return at_corner(board, 0, row) + column * (at_corner(board, 1, row) - at_corner(board, 0, row));
        if (column > last_column) {
            const Eigen::Vector3d last = at_corner(board, last_column, row);
            return last + (column - last_column) * (last - at_corner(board, last_column - 1, row));
        }
        if (row < 0) return at_corner(board, column, 0) + row * (at_corner(board, column, 1) - at_corner(board, column, 0));
        if (row > last_row) {
            const Eigen::Vector3d last = at_corner(board, column, last_row);
            return last + (row - last_row) * (last - at_corner(board, column, last_row - 1));
        }
        const int number = row * nominal.columns + column;
        const Eigen::Vector2d flat = nominal.corner(number);
        return board.corner(number) - Eigen::Vector3d(flat.x(), flat.y(), 0);
    }

    double square_;
    int columns_, rows_;
    std::vector<Eigen::Vector3d> table_;
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

ShownBoard shown(PrintedBoard board, const Hold& hold, Random& random) {
    ShownBoard result{std::move(board)};
    for (int i = 0; i < 3; ++i) result.board.shape[i] += random.normal(hold.bend);
    for (int i = 0; i < 6; ++i) result.motion[i] = random.normal(i < 3 ? hold.shift : hold.turn);
    return result;
}

void photograph(PlanePictures& pictures, const FlatPattern& pattern, const ShownBoard& shown, const Eigen::Isometry3d& camera_from_board, std::uint64_t index,
                LumaImage& picture) {
    const BoardError error(shown.board);
    const auto printed = [&](const Eigen::Vector2d& p) { return pattern(p - error(p).head<2>()); };
    pictures.render(
        printed, camera_from_board, index, picture, [&](const Eigen::Vector2d& p) { return error(p).z(); }, shown.motion);
}

Eigen::Vector2d seen_corner(const CameraModel& camera, const Eigen::Isometry3d& camera_from_board, const ShownBoard& shown, int number) {
    constexpr int rounds = 3;  // when it is seen depends on where
    const Eigen::Vector3d corner = shown.board.corner(number);
    Eigen::Vector2d pixel = *project(camera, camera_from_board * corner);
    for (int round = 0; round < rounds; ++round) {
        const double late = (pixel.y() + 0.5) / camera.height - 0.5;
        pixel = *project(camera, perturbed(camera_from_board, late * shown.motion) * corner);
    }
    return pixel;
}

std::vector<BoardShot> seen_boards(const CameraModel& camera, const PrintedBoard& board, const Hold& hold, int count, double noise, Random& random) {
    std::vector<BoardShot> shots;
    for (const Eigen::Isometry3d& pose : board_poses(camera, board.nominal.corner(board.nominal.corners() - 1), count, random)) {
        BoardShot shot{.name = fmt::format("shot {}", shots.size()), .corners = {}, .edge_width = 2, .square_pixels = 30, .refused = {}};
        const ShownBoard here = shown(board, hold, random);
        for (int i = 0; i < board.nominal.corners(); ++i) {
            shot.corners.push_back(seen_corner(camera, pose, here, i) + normal2(random, noise));
        }
        shots.push_back(shot);
    }
    return shots;
}

}  // namespace roomfix
