#include "roomfix/calibrate/board_turns.hpp"

#include <algorithm>
#include <utility>

#include "roomfix/base/decompositions.hpp"

namespace roomfix {
namespace {

/// Where each corner was printed beside its place, in the plane of the board; zero where a shot does not show it. 2 x corners, m.
using Print = Eigen::Matrix2Xd;

Print turned(const Print& print, const Chessboard& board, int quarters) {
    Eigen::Matrix2d turn = Eigen::Matrix2d::Identity();
    const Eigen::Matrix2d quarter{{0, -1}, {1, 0}};
    for (int i = 0; i < quarters; ++i) turn = quarter * turn;
    Print result(2, print.cols());
    for (int i = 0; i < board.corners(); ++i) result.col(turned_number(board, i, quarters)) = turn * print.col(i);
    return result;
}

/// What one shot tells of the print.
Print print_by(const LensUnknowns& unknowns, const HeldBoard& held, const ShotFit& fit, const BoardShot& shot) {
    Print print = Print::Zero(2, unknowns.board.nominal.corners());
    for (std::size_t i = 0; i < shot.corners.size(); ++i) {
        const int number = shot.number(i);
        ProjectionJacobian by_point;
        if (!project(unknowns.model, held.camera_from_board * unknowns.board.corner(number), &by_point)) continue;
        const Eigen::Matrix2d by_place = by_point * held.camera_from_board.linear().leftCols<2>();
        print.col(number) = unknowns.board.corner(number).head<2>() - unknowns.board.nominal.corner(number) + by_place.inverse() * fit.residuals[i];
    }
    return print;
}

}  // namespace

BoardShot counted_turned(const BoardShot& shot, const Chessboard& board, int times) {
    std::vector<std::pair<int, Eigen::Vector2d>> corners;
    for (std::size_t i = 0; i < shot.corners.size(); ++i) {
        corners.emplace_back(turned_number(board, shot.number(i), times * quarter_turns_alike(board)), shot.corners[i]);
    }
    std::sort(corners.begin(), corners.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    BoardShot result = shot;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        result.corners[i] = corners[i].second;
        if (!result.numbers.empty()) result.numbers[i] = corners[i].first;
    }
    return result;
}

std::vector<int> turns_by_print(const LensUnknowns& unknowns, const LensFit& fit, const std::vector<const BoardShot*>& shots) {
    constexpr int most_rounds = 20;
    const Chessboard& board = unknowns.board.nominal;
    const int alike = quarter_turns_alike(board), ways = 4 / alike;
    std::vector<int> turns(shots.size(), 0);
    std::vector<Print> prints;
    for (std::size_t i = 0; i < shots.size(); ++i) prints.push_back(print_by(unknowns, unknowns.held[i], fit.shots[i], *shots[i]));
    // Each is turned to what the others show: at first those before it, then all.
    std::vector<Print> counted(shots.size(), Print::Zero(2, board.corners()));
    Print sum = Print::Zero(2, board.corners());
    for (int round = 0; round < most_rounds; ++round) {
        bool changed = false;
        for (std::size_t i = 0; i < shots.size(); ++i) {
            sum -= counted[i];
            int best = 0;
            double most = 0;
            for (int way = 0; way < ways; ++way) {
                const double likeness = turned(prints[i], board, way * alike).cwiseProduct(sum).sum();
                if (way == 0 || likeness > most) most = likeness, best = way;
            }
            changed = changed || best != turns[i];
            turns[i] = best;
            counted[i] = turned(prints[i], board, best * alike);
            sum += counted[i];
        }
        if (!changed) break;
    }
    return turns;
}

}  // namespace roomfix
