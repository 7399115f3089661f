#include "roomfix/calibrate/charuco.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <map>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#ifdef ROOMFIX_CHARUCO
#include <opencv2/aruco.hpp>
#endif

#include "roomfix/calibrate/saddle.hpp"

namespace roomfix {

std::vector<BoardMarker> markers_of(const Chessboard& board, bool old_layout) {
    std::vector<BoardMarker> markers;
    const int columns = board.columns + 1, rows = board.rows + 1;
    for (int row = 0; row < rows; ++row) {
        for (int column = 0; column < columns; ++column) {
            // The upper left square is black; in the old layout the lower left one was.
            const int from = old_layout ? rows - 1 - row : row;
            if (from % 2 != column % 2) markers.push_back({static_cast<int>(markers.size()), column, row});
        }
    }
    return markers;
}

#ifndef ROOMFIX_CHARUCO

bool can_read_charuco() { return false; }
std::vector<std::string> marker_dictionaries() { return {}; }
Result<void> check_charuco(const Chessboard&) {
    return Error{"this roomfix was built without OpenCV's aruco module: install libopencv-contrib-dev and build it again, or use a chessboard without markers"};
}
BoardShot find_charuco(LumaView, const Chessboard& board, const std::string& name) { return {name, {}, 0, 0, check_charuco(board).error().message, {}}; }
std::vector<std::vector<bool>> marker_bits(const Chessboard&, int) { return {}; }

#else

namespace {

constexpr std::array<std::pair<const char*, int>, 21> dictionaries = {{
    {"DICT_4X4_50", cv::aruco::DICT_4X4_50},
    {"DICT_4X4_100", cv::aruco::DICT_4X4_100},
    {"DICT_4X4_250", cv::aruco::DICT_4X4_250},
    {"DICT_4X4_1000", cv::aruco::DICT_4X4_1000},
    {"DICT_5X5_50", cv::aruco::DICT_5X5_50},
    {"DICT_5X5_100", cv::aruco::DICT_5X5_100},
    {"DICT_5X5_250", cv::aruco::DICT_5X5_250},
    {"DICT_5X5_1000", cv::aruco::DICT_5X5_1000},
    {"DICT_6X6_50", cv::aruco::DICT_6X6_50},
    {"DICT_6X6_100", cv::aruco::DICT_6X6_100},
    {"DICT_6X6_250", cv::aruco::DICT_6X6_250},
    {"DICT_6X6_1000", cv::aruco::DICT_6X6_1000},
    {"DICT_7X7_50", cv::aruco::DICT_7X7_50},
    {"DICT_7X7_100", cv::aruco::DICT_7X7_100},
    {"DICT_7X7_250", cv::aruco::DICT_7X7_250},
    {"DICT_7X7_1000", cv::aruco::DICT_7X7_1000},
    {"DICT_ARUCO_ORIGINAL", cv::aruco::DICT_ARUCO_ORIGINAL},
    {"DICT_APRILTAG_16h5", cv::aruco::DICT_APRILTAG_16h5},
    {"DICT_APRILTAG_25h9", cv::aruco::DICT_APRILTAG_25h9},
    {"DICT_APRILTAG_36h10", cv::aruco::DICT_APRILTAG_36h10},
    {"DICT_APRILTAG_36h11", cv::aruco::DICT_APRILTAG_36h11},
}};

cv::Ptr<cv::aruco::Dictionary> dictionary_of(const Chessboard& board) {
    for (const auto& [name, number] : dictionaries) {
        if (board.markers && board.markers->dictionary == name) return cv::aruco::getPredefinedDictionary(number);
    }
    return nullptr;
}

constexpr double same_corner = 4;      // px at most between what two markers say of a corner: outlines are read a little too small
constexpr std::size_t least_seen = 8;  // corners of a shot

/// The markers' outlines by their numbers, px. Small pictures are enlarged first: bits of two pixels are not read otherwise. OpenCV's own
/// refinement of outlines is left alone: it slips to the bits of small markers.
std::map<int, std::vector<cv::Point2f>> detect(const cv::Mat& image, const Chessboard& board) {
    constexpr int wide_enough = 1500;  // px
    const int times = image.cols < wide_enough ? 2 : 1;
    cv::Mat enlarged = image;
    if (times > 1) cv::resize(image, enlarged, {}, times, times, cv::INTER_CUBIC);
    std::vector<std::vector<cv::Point2f>> outlines;
    std::vector<int> ids;
    cv::aruco::detectMarkers(enlarged, dictionary_of(board), outlines, ids);
    std::map<int, std::vector<cv::Point2f>> seen;
    for (std::size_t i = 0; i < ids.size(); ++i) {
        for (cv::Point2f& p : outlines[i]) p = (p + cv::Point2f(0.5F, 0.5F)) / times - cv::Point2f(0.5F, 0.5F);
        seen[ids[i]] = outlines[i];
    }
    return seen;
}

/// Where a marker puts points of the board: pixel from board place in squares.
using Homography = Eigen::Matrix3d;

std::optional<Homography> homography_of(const std::vector<cv::Point2f>& seen, const BoardMarker& marker, double side) {
    const double gap = (1 - side) / 2;
    const auto x = static_cast<float>(marker.column + gap), y = static_cast<float>(marker.row + gap), s = static_cast<float>(side);
    const std::vector<cv::Point2f> board = {{x, y}, {x + s, y}, {x + s, y + s}, {x, y + s}};
    const cv::Mat h = cv::getPerspectiveTransform(board, seen);
    Homography result;
    for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c) result(r, c) = h.at<double>(r, c);
    }
    if (!result.allFinite()) return std::nullopt;
    return result;
}

Eigen::Vector2d at(const Homography& h, double x, double y) { return (h * Eigen::Vector3d(x, y, 1)).hnormalized(); }

/// What one layout of the board makes of the markers.
struct Reading {
    std::vector<Eigen::Vector2d> corners;
    std::vector<Eigen::Vector2d> across, down;  // px, one square along the board's x and y there
    std::vector<int> numbers;
    int contradictions = 0;
};

Reading read(const Chessboard& board, const std::map<int, std::vector<cv::Point2f>>& seen, bool old_layout) {
    const double side = board.markers->size / board.square;
    std::map<std::pair<int, int>, Homography> by_square;
    for (const BoardMarker& marker : markers_of(board, old_layout)) {
        const auto found = seen.find(marker.number);
        if (found == seen.end()) continue;
        if (const auto h = homography_of(found->second, marker, side)) by_square[{marker.column, marker.row}] = *h;
    }
    Reading reading;
    for (int number = 0; number < board.corners(); ++number) {
        const int column = number % board.columns + 1, row = number / board.columns + 1;  // in squares
        std::vector<Eigen::Vector2d> told, across, down;
        for (const int c : {column - 1, column}) {
            for (const int r : {row - 1, row}) {
                const auto h = by_square.find({c, r});
                if (h == by_square.end()) continue;
                told.push_back(at(h->second, column, row));
                across.push_back(at(h->second, column + 0.5, row) - at(h->second, column - 0.5, row));
                down.push_back(at(h->second, column, row + 0.5) - at(h->second, column, row - 0.5));
            }
        }
        if (told.size() != 2) continue;  // a marker beside it is hidden: perhaps the corner is, too
        if ((told[0] - told[1]).norm() > same_corner) {
            ++reading.contradictions;
            continue;
        }
        reading.corners.push_back(0.5 * (told[0] + told[1]));
        reading.across.push_back(0.5 * (across[0] + across[1]));
        reading.down.push_back(0.5 * (down[0] + down[1]));
        reading.numbers.push_back(number);
    }
    return reading;
}

/// Do the corners span the board's plane, not just one line of it?
bool in_one_line(const std::vector<int>& numbers, const Chessboard& board) {
    const auto same = [&](auto part) { return std::all_of(numbers.begin(), numbers.end(), [&](int n) { return part(n) == part(numbers[0]); }); };
    return same([&](int n) { return n % board.columns; }) || same([&](int n) { return n / board.columns; });
}

}  // namespace

bool can_read_charuco() { return true; }

std::vector<std::string> marker_dictionaries() {
    std::vector<std::string> names;
    for (const auto& [name, number] : dictionaries) names.emplace_back(name);
    return names;
}

Result<void> check_charuco(const Chessboard& board) {
    const auto dictionary = dictionary_of(board);
    if (!dictionary) return Error{fmt::format("'{}' is no dictionary of markers: {}", board.markers->dictionary, fmt::join(marker_dictionaries(), ", "))};
    if (!(board.markers->size > 0 && board.markers->size < board.square)) {
        return Error{fmt::format("markers of {} mm do not fit into squares of {} mm", 1e3 * board.markers->size, 1e3 * board.square)};
    }
    const int needed = static_cast<int>(markers_of(board).size());
    if (needed > dictionary->bytesList.rows) {
        return Error{fmt::format("the board has {} markers, {} has only {}", needed, board.markers->dictionary, dictionary->bytesList.rows)};
    }
    return {};
}

BoardShot find_charuco(LumaView picture, const Chessboard& board, const std::string& name) {
    BoardShot shot;
    shot.name = name;
    const cv::Mat image(picture.height, picture.width, CV_8U, const_cast<std::uint8_t*>(picture.data), static_cast<std::size_t>(picture.stride));
    const std::map<int, std::vector<cv::Point2f>> seen = detect(image, board);
    if (seen.empty()) {
        shot.refused = fmt::format("no markers of {} found", board.markers->dictionary);
        return shot;
    }
    Reading reading = read(board, seen, false);
    if (board.rows % 2 == 1) {  // an even number of rows of squares
        Reading old = read(board, seen, true);
        if (old.corners.size() > reading.corners.size()) reading = std::move(old);
    }
    // Nearest edges of the markers must stay out of sight.
    const double free = std::max(1.3 * (1 - board.markers->size / board.square) / 2, 0.12);
    double blur = 0, square = 0;
    for (std::size_t i = 0; i < reading.corners.size(); ++i) {
        const double size = std::min(reading.across[i].norm(), reading.down[i].norm());
        const auto saddle = fit_saddle(picture, reading.corners[i], {reading.across[i]}, {reading.down[i]}, std::max(free * size, least_saddle_radius));
        if (!saddle) continue;
        shot.corners.push_back(saddle->pixel);
        shot.numbers.push_back(reading.numbers[i]);
        blur += saddle->blur;
        square += size;
    }
    const auto count = static_cast<double>(shot.corners.size());
    constexpr double edge_of_blur = 2.563;  // a blurred step goes from 10 to 90 % over so many standard deviations
    shot.edge_width = edge_of_blur * blur / std::max(count, 1.0);
    shot.square_pixels = square / std::max(count, 1.0);
    const bool other_board = 4 * static_cast<std::size_t>(reading.contradictions) > reading.corners.size();
    if (!other_board && shot.corners.size() >= least_seen && !in_one_line(shot.numbers, board)) return shot;
    const std::size_t found = shot.corners.size();
    shot.corners.clear();
    shot.numbers.clear();
    shot.refused = other_board && reading.contradictions > 0
                       ? std::string("the markers are not where this board has them: check --board, --square-mm and --marker-mm")
                       : fmt::format("{} corners between markers in sight, {} in two rows or more are needed", found, least_seen);
    return shot;
}

std::vector<std::vector<bool>> marker_bits(const Chessboard& board, int number) {
    const auto dictionary = dictionary_of(board);
    const int size = dictionary->markerSize + 2;
    cv::Mat image;
    dictionary->drawMarker(number, size, image, 1);
    std::vector<std::vector<bool>> bits(static_cast<std::size_t>(size), std::vector<bool>(static_cast<std::size_t>(size)));
    for (int r = 0; r < size; ++r) {
        for (int c = 0; c < size; ++c) bits[static_cast<std::size_t>(r)][static_cast<std::size_t>(c)] = image.at<std::uint8_t>(r, c) > 127;
    }
    return bits;
}

#endif

}  // namespace roomfix
