#include "roomfix/corner/corner_fit.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "corner/corner_views.hpp"
#include "roomfix/base/random.hpp"

namespace roomfix {
namespace {

/// Pictures of bare rooms, and a fitter for their camera.
struct Room {
    CameraModel model = room_camera();
    RoomRenderer renderer{model, room_sensor(), {}, 61};
    CornerFitter fitter{model};
    LumaImage frame;
    std::uint64_t taken = 0;

    CornerView look(const RoomShot& shot) {
        renderer.render(shot.scene, shot.map_from_camera, shot.light, taken++, frame);
        return truth_of(shot);
    }

    /// A picture from one place in the room, with the true view to fit from.
    CornerFit look_from_beside(Random& random) {
        CornerFit fit;
        fit.view = look(chou1986_shot({1.4, 2.1}, random));
        return fit;
    }
};

/// A view some pixels off.
CornerView moved(CornerView view, Random& random, double turn, double way) {
    view.corner_from_camera = exponential_rotation({random.normal(turn), random.normal(turn), random.normal(turn)}) * view.corner_from_camera;
    view.place += Eigen::Vector2d(random.normal(way), random.normal(way));
    return view;
}

TEST(CornerFit, HoldsTheViewAsExactlyAsItStatesFromSomePixelsOff) {
    Room room;
    Random random(62);
    constexpr int count = 32;
    int held = 0;
    double nees = 0;
    for (int i = 0; i < count; ++i) {
        const CornerView truth = room.look(chou1986_shot(chou1986_places()[static_cast<std::size_t>(i % 16)], random));
        CornerFit fit;
        fit.view = moved(truth, random, 0.002, 0.002);
        if (!room.fitter.refine(room.frame, right_angle, 6, fit)) continue;  // from too far off, or too faint: the reader goes on from there
        ++held;
        const Vector5d error = error_of(truth, fit.view);
        EXPECT_LT(error.tail<2>().norm(), 0.01) << i;
        nees += error.dot(fit.information * error) / excess_scatter(fit);
        const auto support = edge_support(fit, 0.5);
        for (const EdgeSupport& edge : support) EXPECT_GT(edge.seen, 0.6 * edge.visible) << i;
    }
    EXPECT_GT(held, 24);
    // Mean of some 30 chi-squares of 5: 3.3 to 7.2 but for one run in 1000.
    EXPECT_GT(nees / held, 3.2);
    EXPECT_LT(nees / held, 7.3);
}

TEST(CornerFit, ItsPiecesMoveWithTheViewAsTheirSlopesSay) {
    Room room;
    Random random(63);
    CornerFit fit = room.look_from_beside(random);
    ASSERT_TRUE(room.fitter.refine(room.frame, right_angle, 4, fit));
    room.fitter.read(room.frame, right_angle, 1, fit);
    for (Eigen::Index k = 0; k < 5; ++k) {
        Vector5d change = Vector5d::Zero();
        change[k] = 4e-4;  // 0.3 px or so
        CornerFit other = fit;
        other.view.corner_from_camera = exponential_rotation(change.head<3>()) * fit.view.corner_from_camera;
        other.view.place += change.tail<2>();
        room.fitter.read(room.frame, right_angle, 1, other);
        double squares = 0, expected = 0;
        for (const EdgePiece& a : fit.pieces) {
            const auto b = std::find_if(other.pieces.begin(), other.pieces.end(), [&](const EdgePiece& p) { return p.edge == a.edge && p.start == a.start; });
            if (b == other.pieces.end() || !a.seen || !b->seen) continue;
            // What the view has been moved by, the pieces want back.
            const double wanted = -a.slope[k] * change[k];
            squares += std::pow(b->step.offset - a.step.offset - wanted, 2);
            expected += wanted * wanted;
        }
        EXPECT_GT(expected, 0) << k;
        EXPECT_LT(std::sqrt(squares / expected), 0.25) << "unknown " << k;
    }
}

TEST(CornerFit, WhereNoEdgesAreNothingHoldsIt) {
    Room room;
    Random random(64);
    CornerFit fit = room.look_from_beside(random);
    for (int y = 0; y < room.frame.height(); ++y) {
        for (int x = 0; x < room.frame.width(); ++x) room.frame.row(y)[x] = static_cast<std::uint8_t>(std::lround(120 + random.normal(2)));
    }
    const bool held = room.fitter.refine(room.frame, right_angle, 6, fit);
    const auto support = edge_support(fit, 0.5);
    const double seen = support[0].seen + support[1].seen + support[2].seen, visible = support[0].visible + support[1].visible + support[2].visible;
    EXPECT_TRUE(!held || seen < 0.2 * visible);
}

TEST(CornerFit, FarFromTheCornerItsEdgesAreNotSeen) {
    Room room;
    Random random(65);
    CornerFit fit = room.look_from_beside(random);
    const CornerView truth = fit.view;
    fit.view.corner_from_camera = exponential_rotation({0, 0, 0.15}) * truth.corner_from_camera;
    const bool held = room.fitter.refine(room.frame, right_angle, 6, fit);
    const auto support = edge_support(fit, 0.5);
    const auto seen = [](const EdgeSupport& edge) { return edge.seen > 0.6 * edge.visible; };
    EXPECT_FALSE(held && std::all_of(support.begin(), support.end(), seen) && error_of(truth, fit.view).norm() > 0.02);
}

TEST(CornerFit, ACornerBehindTheCameraHasNoPieces) {
    Room room;
    Random random(66);
    CornerFit fit = room.look_from_beside(random);
    fit.view = looking({1, 1}, {0, 0, 0}, 0);
    fit.view.corner_from_camera.col(2) *= -1;  // looks the other way
    fit.view.corner_from_camera.col(0) *= -1;
    EXPECT_FALSE(room.fitter.refine(room.frame, right_angle, 6, fit));
    EXPECT_TRUE(fit.pieces.empty());
}

}  // namespace
}  // namespace roomfix
