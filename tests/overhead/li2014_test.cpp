#include "roomfix/overhead/li2014.hpp"

#include <gtest/gtest.h>

namespace roomfix {
namespace {

View tilted_view() { return {make_camera_model(640, 480, 518, 518, 320, 240), {looking_at({1, 2, 2.3}, {5, 2, 0}), Matrix6d::Zero()}}; }

TEST(Li2014, DistanceAndOffsetAreExactForACameraWithoutRoll) {
    // methods: N is linear in the image row, so K and h_s from one rectangle hold on the whole floor.
    const View view = tilted_view();
    const auto rectangle = li2014_rectangle_ahead(view);
    ASSERT_TRUE(rectangle);
    const auto webcam = Li2014::set_up(view.model, *rectangle, li2014_aisle_ahead(view));
    ASSERT_TRUE(webcam) << webcam.error().message;
    for (const Eigen::Vector2d& p : {Eigen::Vector2d(3.2, 2.5), Eigen::Vector2d(4.4, 1.3), Eigen::Vector2d(7.5, 2.1)}) {
        const auto pixel = project_map_point(view, {p.x(), p.y(), 0});
        const auto found = webcam->floor_point(*pixel);
        ASSERT_TRUE(found);
        EXPECT_LT((*found - p).norm(), 1e-6);
    }
}

TEST(Li2014, ABlobAboveTheFloorIsPlacedTooFarAway) {
    // Why the paper loses its centimetres: R_center is no floor point.
    const View view = tilted_view();
    const auto webcam = Li2014::set_up(view.model, *li2014_rectangle_ahead(view), li2014_aisle_ahead(view));
    const auto found = webcam->floor_point(*project_map_point(view, {4.5, 2, 0.22}));
    ASSERT_TRUE(found);
    EXPECT_GT(found->x(), 4.7);
}

TEST(Li2014, RefusesARectangleThatTellsNothing) {
    const View view = tilted_view();
    auto rectangle = *li2014_rectangle_ahead(view);
    rectangle.length = 0;
    EXPECT_FALSE(Li2014::set_up(view.model, rectangle, {}));
    rectangle = *li2014_rectangle_ahead(view);
    std::swap(rectangle.left_near, rectangle.left_far);
    std::swap(rectangle.right_near, rectangle.right_far);
    EXPECT_FALSE(Li2014::set_up(view.model, rectangle, {})) << "the far edge looks longer than the near one";
}

}  // namespace
}  // namespace roomfix
