#include "roomfix/calibrate/body_axes.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "roomfix/base/random.hpp"

namespace roomfix {
namespace {

constexpr double degree = std::numbers::pi / 180;

/// A prism over a footprint, turned by `angle`.
ConvexPart prism(std::vector<Eigen::Vector2d> footprint, double angle) {
    ConvexPart part;
    for (const Eigen::Vector2d& corner : footprint) {
        const Eigen::Vector2d p = Eigen::Rotation2Dd(angle) * corner;
        for (const double z : {0.0, 0.1}) part.points.emplace_back(p.x(), p.y(), z);
    }
    return part;
}

std::vector<Eigen::Vector2d> rectangle(double length, double width) {
    return {{-length / 2, -width / 2}, {length / 2, -width / 2}, {length / 2, width / 2}, {-length / 2, width / 2}};
}

std::vector<Eigen::Vector2d> circle(double radius) {
    std::vector<Eigen::Vector2d> corners;
    for (int i = 0; i < 36; ++i) corners.emplace_back(radius * std::cos(i * 10 * degree), radius * std::sin(i * 10 * degree));
    return corners;
}

/// Spots on top of a disc of 0.2 m whose colours are the same at both sides of a line, but for `noise`.
BodyLook mirrored_look(const GroundLine& line, double noise, Random& random) {
    const Eigen::Vector2d along(std::cos(line.angle), std::sin(line.angle)), left(-along.y(), along.x());
    BodyLook look;
    for (double x = -0.2; x <= 0.2; x += 0.025) {
        for (double y = -0.2; y <= 0.2; y += 0.025) {
            if (std::hypot(x, y) > 0.2) continue;
            const Eigen::Vector2d p(x, y);
            const double forward = p.dot(along), aside = std::abs(p.dot(left) - line.offset);
            LookSpot spot;
            spot.place = {static_cast<float>(x), static_cast<float>(y), 0.1f};
            for (std::size_t k = 0; k < 3; ++k) {
                const double phase = static_cast<double>(k);
                spot.colour[k] = static_cast<float>(0.6 * std::sin(19 * forward + phase) + 0.6 * std::cos(37 * aside + 2 * phase) + random.normal(noise));
            }
            look.spots.push_back(spot);
        }
    }
    return look;
}

TEST(BodyAxes, WithoutALookTheSmallestBoxTells) {
    for (const double angle : {-31.0, -7.0, 0.0, 18.0, 40.0}) {
        const GroundLine axis = body_axis({prism(rectangle(0.2, 0.14), angle * degree)}, {}, 0.05);
        EXPECT_NEAR(axis.angle, angle * degree, 1 * degree);
        EXPECT_NEAR(axis.offset, 0, 1e-9) << "along the middle of the box";
    }
}

TEST(BodyAxes, ARoundBodyLiesAboutWhatItsLookMirrors) {
    Random random(71);
    for (const double angle : {-25.0, 0.0, 12.0, 33.0}) {
        const GroundLine truth{angle * degree, 0.02};
        const GroundLine axis = body_axis({prism(circle(0.2), 0)}, mirrored_look(truth, 0.05, random), 0.06);
        EXPECT_NEAR(axis.angle, truth.angle, 2 * degree);
        EXPECT_NEAR(axis.offset, truth.offset, 0.01) << "which need not be the middle of the box";
    }
}

/// A hull learned from few pictures: the box around it is smallest a little beside where the body lies. Its look is like its mirror image only here and there.
TEST(BodyAxes, AFaintLookDecidesWhereTheBoxHardlyTells) {
    Random random(72);
    const GroundLine truth{-18 * degree, 0};
    const std::vector<ConvexPart> rough = {prism(circle(0.2), 0), prism(rectangle(0.41, 0.1), 0)};
    const GroundLine axis = body_axis(rough, mirrored_look(truth, 0.45, random), 0.06);
    EXPECT_NEAR(axis.angle, truth.angle, 4 * degree);
    EXPECT_NEAR(axis.offset, footprint_box(rough, axis.angle).middle().y(), 1e-9) << "a faint look tells no line beside the middle";
}

TEST(BodyAxes, APlainBoxDecidesWhereTheLookHardlyTells) {
    Random random(73);
    const GroundLine axis = body_axis({prism(rectangle(0.4, 0.2), 20 * degree)}, mirrored_look({-20 * degree, 0}, 1.5, random), 0.06);
    EXPECT_NEAR(axis.angle, 20 * degree, 3 * degree);
}

}  // namespace
}  // namespace roomfix
