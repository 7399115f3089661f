// A robot's body as the parts that it is made of, and the pixels that it covers.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>
#include <vector>

#include "roomfix/geometry/view.hpp"
#include "roomfix/overhead/silhouette.hpp"
#include "roomfix/site/learned_body.hpp"
#include "roomfix/site/site.hpp"

namespace roomfix {

/// m (1 sigma): bodies whose size is known no better, such as people, are no exact solids.
constexpr double soft_size = 0.05;

/// What a robot looks like from outside: convex parts standing on the floor.
struct Body {
    std::vector<ConvexPart> parts;               // m, robot frame
    std::vector<ConvexPart> core;                // the same, smaller: what is body even if the parts are rough
    double height = 0;                           // m
    double least_part = 1;                       // part of it that the lowest of the parts is high
    double radius = 0;                           // m, of the smallest circle around the origin that holds it on the floor
    double inner_radius = 0;                     // m, of the largest circle around the origin that its footprint holds
    double share_of_box = 1;                     // least part that it covers of the box around it in any picture
    double symmetry = 0;                         // rad after which it looks the same; 0: it has no direction
    double size_sigma = 0.005;                   // m: how well its extent is known
    bool has_edges = false;                      // described well enough for its edges to tell it from other things; its colours are not known
    std::shared_ptr<const LearnedBody> learned;  // its look; null: nobody knows

    bool has_look() const { return learned && !learned->look.spots.empty(); }
    /// A body that looks the same from all sides has colours by height only: they tell it from other things, but not where it stands.
    bool placed_by_look() const { return has_look() && !round(); }

    bool round() const { return symmetry == 0; }
};

/// A robot's parts, or its shape as one part. Cylinders are prisms of 12 sides of the circle's mean radius.
Body body_of(const SiteRobot& robot);

/// A robot's parts, or its shape as one part, for fits of its outline: points of at most ShapePoints::capacity a part. Each states the height, radius,
/// symmetry and size_sigma of the whole body. None where a part has more corners.
std::vector<ShapePoints> outline_parts(const SiteRobot& robot);

/// Pixels begin <= x < end of one row.
struct Span {
    int y = 0;
    int begin = 0;
    int end = 0;
};

/// The pixels of a small picture that a body covers; memory is kept between uses.
struct BodyMask {
    std::vector<Span> spans;                       // no two overlap; from top to bottom
    double area = 0;                               // px, of `spans`
    double whole = 0;                              // px, with what lies outside the picture
    int left = 0, top = 0, right = 0, bottom = 0;  // box around it in the picture, right and bottom exclusive
    bool valid = false;                            // false: some of it is behind the camera or outside the lens model

    /// Covers nothing, in a picture of this size.
    void begin(int width, int height, int row_step);
    /// Adds a convex polygon, px of the small picture.
    void add(std::span<const Eigen::Vector2d> polygon);
    /// After the last one.
    void finish();

    // Working memory.
    int width = 0, height = 0, row_step = 1;
    Eigen::Vector2d low, high;
    std::vector<Eigen::Vector2d> pixels;
    std::vector<int> order, hull;
    std::vector<Span> joined;
};

/// px that two masks of one picture, both of every row, have in common.
double common_area(const BodyMask& a, const BodyMask& b);

/// Covers the pixels of a picture that is `scale` times smaller than the camera's, `width` x `height` px. Only every `row_step`-th row is
/// filled, and counts as often.
void cover(const View& view, const std::vector<ConvexPart>& parts, const Pose2& pose, int width, int height, int scale, int row_step, BodyMask& mask);

/// The convex hull of all pixels that the body covers, px of the camera's picture, at most 64 corners; empty where it is not seen whole.
std::vector<Eigen::Vector2d> outline_of(const View& view, const Body& body, const Pose2& pose);

}  // namespace roomfix
