#include "roomfix/geometry/camera_model.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <Eigen/Geometry>

#include "roomfix/base/random.hpp"

namespace roomfix {
namespace {

/// Of every kind of lens.
CameraModel random_model(Random& random) {
    const double f = random.uniform(200, 1500);
    const double kind = random.uniform();
    const auto small = [&](double most) { return random.uniform(-most, most); };
    if (kind < 0.3) {
        return make_camera_model(640, 480, f, f * random.uniform(0.98, 1.02), random.uniform(300, 340), random.uniform(220, 260),
                                 {small(0.1), small(0.02), small(0.005), small(0.002)}, Distortion::equidistant);
    }
    if (kind < 0.6) {
        return make_camera_model(640, 480, f, f * random.uniform(0.98, 1.02), random.uniform(300, 340), random.uniform(220, 260),
                                 {small(0.4), small(0.4), small(0.005), small(0.005), small(0.1), small(0.4), small(0.3), small(0.1)},
                                 Distortion::rational_polynomial);
    }
    return make_camera_model(
        640, 480, f, f * random.uniform(0.98, 1.02), random.uniform(300, 340), random.uniform(220, 260),
        {random.uniform(-0.4, 0.3), random.uniform(-0.5, 0.5), random.uniform(-0.005, 0.005), random.uniform(-0.005, 0.005), random.uniform(-1, 1)});
}

/// A lens, and a pixel of its picture.
std::pair<CameraModel, Eigen::Vector2d> random_sight(std::uint64_t seed) {
    Random random(seed);
    const CameraModel model = random_model(random);
    const double x = random.uniform(0, 639);
    return {model, {x, random.uniform(0, 479)}};
}

TEST(CameraModel, PixelToRayAndBackAgreesWherePossible) {
    EXPECT_TRUE(rc::check("project(unproject(p)) == p within 1e-9 px, or unproject says no", [](std::uint64_t seed) {
        const auto [model, pixel] = random_sight(seed);
        const auto ray = unproject(model, pixel);
        if (!ray) return;
        const auto again = project(model, ray->homogeneous());
        RC_ASSERT(again.has_value());
        RC_ASSERT((*again - pixel).norm() < 1e-9);
    }));
}

TEST(CameraModel, ARayBesideAKnownOneIsTheSameAsAlone) {
    EXPECT_TRUE(rc::check("unproject_beside(p, any) == unproject(p)", [](std::uint64_t seed) {
        const auto [model, pixel] = random_sight(seed);
        const auto ray = unproject(model, pixel);
        for (const double off : {1.0, -30.0}) {
            const auto beside = unproject_beside(model, pixel, unproject(model, pixel + Eigen::Vector2d(off, 0)));
            RC_ASSERT(beside.has_value() == ray.has_value());
            if (ray) RC_ASSERT((*beside - *ray).norm() * model.fx < 1e-9);
        }
    }));
}

TEST(CameraModel, APlainLensIsInvertibleEverywhere) {
    const CameraModel model = make_camera_model(640, 480, 500, 500, 320, 240, {-0.1, 0.02, 0.001, -0.001, 0});
    for (int x = 0; x < 640; x += 20) {
        for (int y = 0; y < 480; y += 20) EXPECT_TRUE(unproject(model, Eigen::Vector2d(x, y)).has_value()) << x << ", " << y;
    }
}

TEST(CameraModel, SaysNoBeyondTheFoldOfTheDistortion) {
    // r (1 - r^2) rises until r = 1/sqrt(3), where it is 0.385: nothing is imaged farther out than that.
    const CameraModel model = make_camera_model(640, 480, 500, 500, 320, 240, {-1, 0, 0, 0, 0});
    EXPECT_NEAR(model.max_radius_squared, 1.0 / 3, 1e-9);
    EXPECT_TRUE(unproject(model, {320 + 0.38 * 500, 240}).has_value());
    EXPECT_FALSE(unproject(model, {320 + 0.39 * 500, 240}).has_value());
    EXPECT_FALSE(project(model, {0.7, 0, 1}).has_value()) << "beyond the fold a point would appear where another one is";
    EXPECT_FALSE(project(model, {0, 0, -1}).has_value()) << "behind the camera";
    EXPECT_FALSE(unproject(model, {std::nan(""), 0}).has_value());
}

TEST(CameraModel, DerivativesMatchDifferences) {
    Random random(3);
    for (int i = 0; i < 200; ++i) {
        const CameraModel model = random_model(random);
        const Eigen::Vector3d p(random.uniform(-0.4, 0.4), random.uniform(-0.3, 0.3), random.uniform(0.8, 3));
        ProjectionJacobian jacobian;
        const auto pixel = project(model, p, &jacobian);
        if (!pixel) continue;
        for (int k = 0; k < 3; ++k) {
            constexpr double h = 1e-6;
            const auto ahead = project(model, p + h * Eigen::Vector3d::Unit(k));
            const auto behind = project(model, p - h * Eigen::Vector3d::Unit(k));
            if (!ahead || !behind) continue;
            EXPECT_LT((jacobian.col(k) - (*ahead - *behind) / (2 * h)).norm(), 1e-4 * (1 + jacobian.norm()));
        }
        IntrinsicsJacobian by_intrinsics;
        ASSERT_TRUE(project(model, p, nullptr, &by_intrinsics));
        for (int k = 0; k < model.intrinsics_count(); ++k) {
            const double h = k < 4 ? 1e-3 : 1e-6;
            CameraModel more = model, less = model;
            more.set_intrinsics(model.intrinsics() + h * IntrinsicsVector::Unit(k));
            less.set_intrinsics(model.intrinsics() - h * IntrinsicsVector::Unit(k));
            const auto ahead = project(more, p), behind = project(less, p);
            if (!ahead || !behind) continue;
            EXPECT_LT((by_intrinsics.col(k) - (*ahead - *behind) / (2 * h)).norm(), 1e-4 * (1 + by_intrinsics.norm())) << k;
        }
        Eigen::Matrix2d by_pixel;
        const auto ray = unproject(model, *pixel, &by_pixel);
        ASSERT_TRUE(ray.has_value()) << model.intrinsics().transpose();
        const auto shifted = unproject(model, *pixel + Eigen::Vector2d(1e-3, 0));
        if (!shifted) continue;
        EXPECT_LT((by_pixel.col(0) - (*shifted - *ray) / 1e-3).norm(), 1e-4 * (1 + by_pixel.norm()));
    }
}

TEST(CameraModel, AFisheyeWithoutFurtherBendingGivesTheAngle) {
    const CameraModel model = make_camera_model(1000, 1000, 300, 300, 500, 500, {}, Distortion::equidistant);
    const double angle = 1.2;
    const auto pixel = project(model, {std::sin(angle), 0, std::cos(angle)});
    ASSERT_TRUE(pixel);
    EXPECT_NEAR(pixel->x(), 500 + 300 * angle, 1e-9);
}

TEST(CameraModel, AnotherResolutionShowsTheSameRaysInTheSamePlaces) {
    const CameraModel model = make_camera_model(640, 480, 520, 521, 318, 241, {-0.1, 0.02, 0.001, -0.001, 0});
    const auto half = rescaled(model, 320, 240);
    ASSERT_TRUE(half);
    const Eigen::Vector3d p(0.2, -0.1, 1);
    // The centre of pixel (0, 0) of the small picture is the corner that four pixels of the large one share.
    EXPECT_LT((*project(*half, p) - (0.5 * (*project(model, p)).array() - 0.25).matrix()).norm(), 1e-9);
    EXPECT_FALSE(rescaled(model, 640, 360));
    EXPECT_FALSE(rescaled(model, 0, 0));
}

}  // namespace
}  // namespace roomfix
