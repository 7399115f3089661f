#include "roomfix/calibrate/chessboard.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "roomfix/base/median.hpp"
#include "roomfix/base/number.hpp"
#include "roomfix/calibrate/charuco.hpp"
#include "roomfix/calibrate/saddle.hpp"

namespace roomfix {
namespace {

constexpr double blurred_by_median = 1.7;   // times the median of all shots' edges
constexpr double blurred_by_square = 0.25;  // part of a square that an edge may take
constexpr double sharp_enough = 4;          // px: never too wide
constexpr double look = 0.7;                // of a square: how far around a corner light is read ...
constexpr double widest_look = 12;          // px: ... and no farther, for lenses bend lines
constexpr int rounds = 3;                   // better corners tell better how lines are bent, and where the others are
constexpr double least_read = 0.5;          // of the corners
constexpr double same_place = 0.015;        // of the diagonal, rms over the corners

cv::Mat mat_of(LumaView picture) {
    return {picture.height, picture.width, CV_8U, const_cast<std::uint8_t*>(picture.data), static_cast<std::size_t>(picture.stride)};
}

/// Mean distance of neighbouring corners, and the least.
std::pair<double, double> spacing(const std::vector<cv::Point2f>& corners, const Chessboard& board) {
    double sum = 0, least = 1e300;
    int count = 0;
    const auto add = [&](int a, int b) {
        const double distance = cv::norm(corners[static_cast<std::size_t>(a)] - corners[static_cast<std::size_t>(b)]);
        sum += distance;
        least = std::min(least, distance);
        ++count;
    };
    for (int i = 0; i < board.corners(); ++i) {
        if (i % board.columns + 1 < board.columns) add(i, i + 1);
        if (i / board.columns + 1 < board.rows) add(i, i + board.columns);
    }
    return {sum / count, least};
}

bool detect(LumaView picture, const Chessboard& board, std::vector<cv::Point2f>& corners) {
    return cv::findChessboardCorners(mat_of(picture), {board.columns, board.rows}, corners,
                                     cv::CALIB_CB_ADAPTIVE_THRESH | cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_FAST_CHECK);
}

/// Root mean square distance between the corners that two shots share, or a large one where they share few; of all ways to count them.
double distance(const BoardShot& a, const BoardShot& b, const Chessboard& board) {
    std::map<int, Eigen::Vector2d> own;
    for (std::size_t i = 0; i < a.corners.size(); ++i) own[a.number(i)] = a.corners[i];
    double least = 1e300;
    for (int quarters = 0; quarters < 4; quarters += quarter_turns_alike(board)) {
        double squares = 0;
        std::size_t shared = 0;
        for (std::size_t i = 0; i < b.corners.size(); ++i) {
            const auto same = own.find(turned_number(board, b.number(i), quarters));
            if (same == own.end()) continue;
            squares += (same->second - b.corners[i]).squaredNorm();
            ++shared;
        }
        if (10 * shared >= 9 * std::min(a.corners.size(), b.corners.size())) least = std::min(least, std::sqrt(squares / static_cast<double>(shared)));
    }
    return least;
}

/// How a lens bends the line through three corners in a row, at the middle one: 1/px, to the left of the way from the first to the last.
double bend_of(const Eigen::Vector2d& before, const Eigen::Vector2d& here, const Eigen::Vector2d& after) {
    const Eigen::Vector2d way = (after - before).normalized(), normal(-way.y(), way.x());
    return -2 * normal.dot(here - before) / ((here - before).norm() * (after - here).norm());
}

/// Where three corners in a row that were read say that the next one is: rows bend evenly. The mean of all such rows; `otherwise` if there is none.
Eigen::Vector2d continued(const Chessboard& board, const std::vector<Eigen::Vector2d>& corners, const std::vector<bool>& read, int number,
                          const Eigen::Vector2d& otherwise) {
    const int column = number % board.columns, row = number / board.columns;
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    int rows = 0;
    for (const auto& [x, y] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
        const int last_column = column + 3 * x, last_row = row + 3 * y;
        if (last_column < 0 || last_row < 0 || last_column >= board.columns || last_row >= board.rows) continue;
        const auto step = static_cast<std::size_t>(y * board.columns + x), at = static_cast<std::size_t>(number);
        if (!read[at + step] || !read[at + 2 * step] || !read[at + 3 * step]) continue;
        sum += 3 * corners[at + step] - 3 * corners[at + 2 * step] + corners[at + 3 * step];
        ++rows;
    }
    return rows > 0 ? (sum / rows).eval() : otherwise;
}

/// Each corner again from all pixels around it, within the squares. `read`: where that went well; the others are looked for where their neighbours say.
void refine(LumaView picture, const Chessboard& board, std::vector<Eigen::Vector2d>& corners, std::vector<bool>& read) {
    std::vector<Eigen::Vector2d> first = corners;
    for (int i = 0; i < board.corners(); ++i) {
        const auto k = static_cast<std::size_t>(i);
        if (!read[k]) first[k] = continued(board, corners, read, i, corners[k]);
    }
    const auto at = [&](int column, int row) { return first[static_cast<std::size_t>(row * board.columns + column)]; };
    for (int i = 0; i < board.corners(); ++i) {
        const int column = i % board.columns, row = i / board.columns;
        // At the board's rim the next corner inwards tells how lines are bent.
        const int c = std::clamp(column, 1, board.columns - 2), r = std::clamp(row, 1, board.rows - 2);
        const SaddleEdge across{at(std::min(column + 1, board.columns - 1), row) - at(std::max(column - 1, 0), row),
                                bend_of(at(c - 1, row), at(c, row), at(c + 1, row))};
        const SaddleEdge down{at(column, std::min(row + 1, board.rows - 1)) - at(column, std::max(row - 1, 0)),
                              bend_of(at(column, r - 1), at(column, r), at(column, r + 1))};
        // No nearer corner comes into sight.
        double square = 1e300;
        for (const auto& [x, y] : {std::pair{column - 1, row}, {column + 1, row}, {column, row - 1}, {column, row + 1}}) {
            if (x >= 0 && y >= 0 && x < board.columns && y < board.rows) square = std::min(square, (at(x, y) - at(column, row)).norm());
        }
        const double crossing = std::abs(across.along.x() * down.along.y() - across.along.y() * down.along.x()) / (across.along.norm() * down.along.norm());
        const double radius = std::min(widest_look, look * square * crossing);
        if (radius < least_saddle_radius) continue;
        const auto saddle = fit_saddle(picture, at(column, row), across, down, radius);
        read[static_cast<std::size_t>(i)] = saddle.has_value();
        if (saddle) corners[static_cast<std::size_t>(i)] = saddle->pixel;
    }
}

/// Corners that are hidden, or lost in a glare.
void leave_out_unread(const std::vector<bool>& read, BoardShot& shot) {
    const auto good = std::count(read.begin(), read.end(), true);
    const auto all = static_cast<std::ptrdiff_t>(read.size());
    if (good == all) return;
    if (static_cast<double>(good) < least_read * static_cast<double>(all)) {
        shot.refused = fmt::format("only {} of {} corners can be read: is there glare, or something before the board?", good, all);
        return;
    }
    std::vector<Eigen::Vector2d> corners;
    for (std::size_t i = 0; i < read.size(); ++i) {
        if (!read[i]) continue;
        corners.push_back(shot.corners[i]);
        shot.numbers.push_back(static_cast<int>(i));
    }
    shot.corners = std::move(corners);
}

}  // namespace

int quarter_turns_alike(const Chessboard& board) {
    if (board.markers || (board.columns + board.rows) % 2 != 0) return 4;
    return board.columns == board.rows ? 1 : 2;
}

int turned_number(const Chessboard& board, int number, int quarters) {
    int column = number % board.columns, row = number / board.columns;
    int columns = board.columns, rows = board.rows;
    for (int i = 0; i < quarters; ++i) {
        const int before = column;
        column = rows - 1 - row;
        row = before;
        std::swap(columns, rows);
    }
    return row * columns + column;
}

BoardShot find_board(LumaView picture, const Chessboard& board, const std::string& name) {
    return board.markers ? find_charuco(picture, board, name) : find_chessboard(picture, board, name);
}

BoardShot find_chessboard(LumaView picture, const Chessboard& board, const std::string& name) {
    BoardShot shot;
    shot.name = name;
    std::vector<cv::Point2f> corners;
    if (!detect(picture, board, corners)) {
        shot.refused = fmt::format("no board with {} x {} inner corners found", board.columns, board.rows);
        return shot;
    }
    const auto [mean, least] = spacing(corners, board);
    const int window = std::clamp(static_cast<int>(0.4 * least), 2, 11);
    cv::cornerSubPix(mat_of(picture), corners, {window, window}, {-1, -1}, {cv::TermCriteria::EPS | cv::TermCriteria::COUNT, 100, 1e-4});
    shot.square_pixels = mean;
    shot.edge_width = cv::estimateChessboardSharpness(mat_of(picture), {board.columns, board.rows}, corners)[0];
    for (const cv::Point2f& c : corners) shot.corners.emplace_back(static_cast<double>(c.x), static_cast<double>(c.y));
    std::vector<bool> read(shot.corners.size(), true);
    for (int round = 0; round < rounds; ++round) refine(picture, board, shot.corners, read);
    leave_out_unread(read, shot);
    return shot;
}

void refuse_poor_shots(std::vector<BoardShot>& shots, const Chessboard& board, double diagonal) {
    std::vector<double> widths;
    for (const BoardShot& s : shots) {
        if (s.refused.empty()) widths.push_back(s.edge_width);
    }
    if (widths.empty()) return;
    const double usual = median(widths);
    for (BoardShot& s : shots) {
        if (!s.refused.empty() || s.edge_width <= sharp_enough) continue;
        if (s.edge_width > blurred_by_median * usual || s.edge_width > blurred_by_square * s.square_pixels) {
            s.refused = fmt::format("blurred: edges are {:.1f} px wide, those of the others {:.1f} px; hold board and camera still", s.edge_width, usual);
        }
    }
    // The sharpest of those that show the same stays.
    std::vector<BoardShot*> sharpest;
    for (BoardShot& s : shots) {
        if (s.refused.empty()) sharpest.push_back(&s);
    }
    std::stable_sort(sharpest.begin(), sharpest.end(), [](const BoardShot* a, const BoardShot* b) { return a->edge_width < b->edge_width; });
    std::vector<const BoardShot*> kept;
    for (BoardShot* s : sharpest) {
        const auto like = std::find_if(kept.begin(), kept.end(), [&](const BoardShot* k) { return distance(*k, *s, board) < same_place * diagonal; });
        if (like != kept.end()) {
            s->refused = fmt::format("shows the board where {} does", (*like)->name);
        } else {
            kept.push_back(s);
        }
    }
}

std::optional<Chessboard> other_board_in(LumaView picture, const Chessboard& board) {
    constexpr int least = 3, farthest = 2;  // corners each way; more off than that, it is no slip of counting
    std::vector<cv::Point2f> corners;
    cv::Mat squares;
    const bool found = cv::findChessboardCornersSB(mat_of(picture), {least, least}, corners, cv::CALIB_CB_LARGER | cv::CALIB_CB_NORMALIZE_IMAGE, squares);
    if (!found) return std::nullopt;
    const int across = std::max(squares.cols, squares.rows), along = std::min(squares.cols, squares.rows);
    const bool upright = board.columns < board.rows;
    const Chessboard other{upright ? along : across, upright ? across : along, board.square};
    const bool near = std::max(std::abs(other.columns - board.columns), std::abs(other.rows - board.rows)) <= farthest;
    // A part of a board is none of that size: what is named must be found as such.
    return near && detect(picture, other, corners) ? std::optional(other) : std::nullopt;
}

std::string board_svg(const Chessboard& board) {
    const double square = 1e3 * board.square, margin = std::max(0.4 * square, 8.0);  // nine by six squares of 25 mm go onto A4
    const double width = (board.columns + 1) * square + 2 * margin, height = (board.rows + 1) * square + 2 * margin + 14;
    std::string squares;
    for (int y = 0; y <= board.rows; ++y) {
        for (int x = 0; x <= board.columns; ++x) {
            if ((x + y) % 2 != 0) continue;
            squares += fmt::format("<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"/>\n", number_text(margin + x * square), number_text(margin + y * square),
                                   number_text(square), number_text(square));
        }
    }
    if (board.markers) {
        for (const BoardMarker& marker : markers_of(board)) {
            const double side = 1e3 * board.markers->size, gap = (square - side) / 2;
            const auto bits = marker_bits(board, marker.number);
            const double bit = side / static_cast<double>(bits.size());
            const double x0 = margin + marker.column * square + gap, y0 = margin + marker.row * square + gap;
            squares +=
                fmt::format("<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"/>\n", number_text(x0), number_text(y0), number_text(side), number_text(side));
            for (std::size_t r = 0; r < bits.size(); ++r) {
                for (std::size_t c = 0; c < bits.size(); ++c) {
                    if (!bits[r][c]) continue;
                    squares += fmt::format("<rect x=\"{:.4f}\" y=\"{:.4f}\" width=\"{:.4f}\" height=\"{:.4f}\" fill=\"white\"/>\n",
                                           x0 + bit * static_cast<double>(c), y0 + bit * static_cast<double>(r), bit, bit);
                }
            }
        }
    }
    const double ruler_y = height - 11;
    std::string ruler = fmt::format("<path d=\"M{} {}h100\" stroke=\"black\" stroke-width=\"0.3\"/>", number_text(margin), number_text(ruler_y));
    for (int mm = 0; mm <= 100; mm += 5) {
        ruler += fmt::format("<path d=\"M{} {}v-{}\" stroke=\"black\" stroke-width=\"0.3\"/>", number_text(margin + mm), number_text(ruler_y),
                             mm % 10 == 0 ? 3 : 1.5);
        if (mm % 20 == 0)
            ruler += fmt::format("<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">{}</text>", number_text(margin + mm), number_text(ruler_y + 4), mm);
    }
    const std::string what = fmt::format("{} x {} inner corners, squares of {:g} mm{}", board.columns, board.rows, square,
                                         board.markers ? fmt::format(", markers {} of {:g} mm", board.markers->dictionary, 1e3 * board.markers->size) : "");
    return fmt::format(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}mm\" height=\"{1}mm\" viewBox=\"0 0 {0} {1}\" font-family=\"sans-serif\" font-size=\"3.2\" "
        "shape-rendering=\"crispEdges\">\n<rect width=\"{0}\" height=\"{1}\" fill=\"white\"/>\n{2}{3}\n<text x=\"{4}\" y=\"{5}\">{6}</text>\n"
        "<text x=\"{7}\" y=\"{8}\">Print at 100 %: the ruler must measure 100 mm. If it does not, measure ten squares and give their size.</text>\n</svg>\n",
        number_text(width), number_text(height), squares, ruler, number_text(margin + 106), number_text(ruler_y), what, number_text(margin),
        number_text(height - 2.5));
}

}  // namespace roomfix
