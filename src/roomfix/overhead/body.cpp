#include "roomfix/overhead/body.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "roomfix/geometry/convex_hull.hpp"
#include "roomfix/site/body_parts.hpp"

namespace roomfix {
namespace {

ConvexPart part_of(const Shape& shape) {
    ConvexPart part;
    const Eigen::Vector3d half = half_size(shape);
    if (std::holds_alternative<Box>(shape)) {
        for (int i = 0; i < 8; ++i) part.points.emplace_back(i & 1 ? half.x() : -half.x(), i & 2 ? half.y() : -half.y(), i & 4 ? 2 * half.z() : 0);
        return part;
    }
    constexpr int sides = 12;
    const double radius = half.x() * (1 + 0.25 * std::pow(std::numbers::pi / sides, 2));
    for (int i = 0; i < 2 * sides; ++i) {
        const double angle = 2 * std::numbers::pi * (i % sides) / sides;
        part.points.emplace_back(radius * std::cos(angle), radius * std::sin(angle), i < sides ? 0 : 2 * half.z());
    }
    return part;
}

/// A part drawn in towards its own axis, and a little from above.
ConvexPart core_of(const ConvexPart& part) {
    constexpr double across = 0.65;
    constexpr double up = 0.90;
    Eigen::Vector2d middle = Eigen::Vector2d::Zero();
    double foot = 1e9;
    for (const Eigen::Vector3d& p : part.points) {
        middle += p.head<2>() / static_cast<double>(part.points.size());
        foot = std::min(foot, p.z());
    }
    ConvexPart core = part;
    for (Eigen::Vector3d& p : core.points) {
        p.head<2>() = middle + across * (p.head<2>() - middle);
        p.z() = foot + up * (p.z() - foot);
    }
    return core;
}

/// Joins the spans of one more polygon, behind the first `before`, with those, both from top to bottom and from left to right. `joined`: working memory.
void join(std::vector<Span>& spans, std::size_t before, std::vector<Span>& joined) {
    joined.clear();
    const auto add = [&](const Span& span) {
        if (!joined.empty() && joined.back().y == span.y && span.begin <= joined.back().end) {
            joined.back().end = std::max(joined.back().end, span.end);
        } else {
            joined.push_back(span);
        }
    };
    std::size_t a = 0, b = before;
    while (a < before || b < spans.size()) {
        const bool first = b == spans.size() || (a < before && (spans[a].y != spans[b].y ? spans[a].y < spans[b].y : spans[a].begin < spans[b].begin));
        add(spans[first ? a++ : b++]);
    }
    spans.swap(joined);
}

/// Radius of the largest circle around the origin inside the hull of all parts, seen from above; 0 where the origin is outside.
double inner_radius_of(const std::vector<ConvexPart>& parts) {
    std::vector<Eigen::Vector2d> points;
    for (const ConvexPart& part : parts) {
        for (const Eigen::Vector3d& p : part.points) points.push_back(p.head<2>());
    }
    const std::vector<Eigen::Vector2d> hull = hull_of(points);
    double radius = hull.size() < 3 ? 0 : 1e9;
    for (std::size_t i = 0; i < hull.size(); ++i) {
        const Eigen::Vector2d& a = hull[i];
        const Eigen::Vector2d& b = hull[(i + 1) % hull.size()];
        const Eigen::Vector2d side = (b - a).normalized();
        radius = std::min(radius, a.x() * side.y() - a.y() * side.x());
    }
    return std::max(radius, 0.0);
}

/// The least part that a body covers of the boxes around it, seen from above and from four sides: twice its radius wide, and as high as it is seen from
/// anywhere.
double share_of_box(const Body& body) {
    constexpr int cells = 64;
    BodyMask mask;
    const double across = cells / (2 * body.radius);
    const double upward = cells / (body.height + 2 * body.radius);
    double share = 1;
    for (int view = -1; view < 4; ++view) {
        const Eigen::Vector2d right(std::cos(view * std::numbers::pi / 4), std::sin(view * std::numbers::pi / 4));
        mask.begin(cells, cells, 1);
        for (const ConvexPart& part : body.parts) {
            std::vector<Eigen::Vector2d> pixels;
            for (const Eigen::Vector3d& p : part.points) {
                const double x = view < 0 ? p.x() : p.head<2>().dot(right);
                const double y = view < 0 ? across * (p.y() + body.radius) : upward * p.z();
                pixels.emplace_back(across * (x + body.radius), y);
            }
            const std::vector<Eigen::Vector2d> hull = hull_of(pixels);
            if (hull.size() > 2) mask.add(hull);
        }
        mask.finish();
        share = std::min(share, mask.area / (cells * cells));
    }
    return share;
}

}  // namespace

Body body_of(const SiteRobot& robot) {
    Body body;
    body.size_sigma = robot.size_sigma;
    body.parts = robot.parts.empty() ? std::vector{part_of(robot.shape)} : robot.parts;
    double lowest = 1e9;
    for (const ConvexPart& part : body.parts) {
        body.core.push_back(core_of(part));
        double foot = 1e9, top = 0;
        for (const Eigen::Vector3d& p : part.points) {
            foot = std::min(foot, p.z());
            top = std::max(top, p.z());
            body.radius = std::max(body.radius, p.head<2>().norm());
        }
        body.height = std::max(body.height, top);
        lowest = std::min(lowest, top - foot);
    }
    if (body.height > 0) body.least_part = lowest / body.height;
    body.inner_radius = inner_radius_of(body.parts);
    body.has_edges = robot.parts.size() > 1 && !robot.learned && robot.size_sigma < soft_size;
    if (body.has_edges) body.share_of_box = share_of_box(body);  // others are found by so much that only plain ones are worth a look
    body.learned = robot.learned;
    if (robot.learned) {
        body.symmetry = robot.learned->symmetry;
    } else {
        body.symmetry = robot.parts.empty() ? shape_points(robot.shape, robot.size_sigma).symmetry : symmetry_of(robot.parts);
    }
    return body;
}

std::vector<ShapePoints> outline_parts(const SiteRobot& robot) {
    if (robot.parts.empty()) return {shape_points(robot.shape, robot.size_sigma)};
    const Body body = body_of(robot);
    std::vector<ShapePoints> result;
    for (const ConvexPart& part : body.parts) {
        if (part.points.size() > ShapePoints::capacity) return {};
        ShapePoints points;
        std::copy(part.points.begin(), part.points.end(), points.points.begin());
        points.count = static_cast<int>(part.points.size());
        points.height = body.height;
        points.radius = body.radius;
        points.symmetry = body.symmetry;
        points.size_sigma = body.size_sigma;
        result.push_back(points);
    }
    return result;
}

void BodyMask::begin(int picture_width, int picture_height, int step) {
    width = picture_width;
    height = picture_height;
    row_step = step;
    spans.clear();
    area = whole = 0;
    valid = false;
    low = Eigen::Vector2d::Constant(1e9);
    high = -low;
}

void BodyMask::add(std::span<const Eigen::Vector2d> polygon) {
    const PixelBox box = box_around(polygon);
    low = low.cwiseMin(box.low);
    high = high.cwiseMax(box.high);
    whole += polygon_area(polygon);
    const std::size_t before = spans.size();
    const double rows = std::min(box.high.y(), height - 1.0) - std::max(box.low.y(), 0.0);
    if (!(rows >= 0)) return;
    spans.resize(before + static_cast<std::size_t>(rows / row_step) + 2);
    Span* next = spans.data() + before;
    for_polygon_rows(polygon, width, height, row_step, [&](int y, int begin, int end) {
        next->y = y;  // each by itself: two ints put together to be stored at once make the processor wait
        next->begin = begin;
        next->end = end;
        ++next;
    });
    spans.resize(static_cast<std::size_t>(next - spans.data()));
    if (before > 0) join(spans, before, joined);
}

void BodyMask::finish() {
    for (const Span& span : spans) area += (span.end - span.begin) * row_step;
    whole = std::max(whole, area);
    left = std::clamp(static_cast<int>(std::floor(std::clamp(low.x(), -1.0, 1e5))), 0, width);
    top = std::clamp(static_cast<int>(std::floor(std::clamp(low.y(), -1.0, 1e5))), 0, height);
    right = std::clamp(static_cast<int>(std::ceil(std::clamp(high.x(), -1.0, 1e5))) + 1, left, width);
    bottom = std::clamp(static_cast<int>(std::ceil(std::clamp(high.y(), -1.0, 1e5))) + 1, top, height);
    valid = true;
}

double common_area(const BodyMask& a, const BodyMask& b) {
    double area = 0;
    for (auto s = a.spans.begin(), t = b.spans.begin(); s != a.spans.end() && t != b.spans.end();) {
        if (s->y == t->y) area += std::max(std::min(s->end, t->end) - std::max(s->begin, t->begin), 0);
        const bool first_ends = s->y != t->y ? s->y < t->y : s->end < t->end;
        ++(first_ends ? s : t);
    }
    return area;
}

void cover(const View& view, const std::vector<ConvexPart>& parts, const Pose2& pose, int width, int height, int scale, int row_step, BodyMask& mask) {
    mask.begin(width, height, row_step);
    const Eigen::Matrix3d camera_from_map = view.map_from_camera.pose.linear().transpose();
    const Eigen::Vector3d position = view.position();
    const double c = std::cos(pose.yaw);
    const double s = std::sin(pose.yaw);
    std::vector<Eigen::Vector2d>& pixels = mask.pixels;
    for (const ConvexPart& part : parts) {
        pixels.clear();
        for (const Eigen::Vector3d& p : part.points) {
            const Eigen::Vector3d map(pose.x + c * p.x() - s * p.y(), pose.y + s * p.x() + c * p.y(), p.z());
            const auto pixel = project(view.model, camera_from_map * (map - position));
            if (!pixel) return;
            pixels.push_back((*pixel - Eigen::Vector2d::Constant(0.5 * (scale - 1))) / scale);
        }
        mask.order.resize(pixels.size() + 1);
        mask.hull.resize(pixels.size() + 1);
        const int corners = convex_hull(pixels, mask.order, mask.hull);
        if (corners < 3) continue;
        const std::size_t points = pixels.size();
        for (int i = 0; i < corners; ++i) pixels.push_back(pixels[static_cast<std::size_t>(mask.hull[static_cast<std::size_t>(i)])]);
        mask.add({pixels.data() + points, static_cast<std::size_t>(corners)});
    }
    mask.finish();
}

std::vector<Eigen::Vector2d> outline_of(const View& view, const Body& body, const Pose2& pose) {
    std::vector<Eigen::Vector2d> pixels;
    const double c = std::cos(pose.yaw);
    const double s = std::sin(pose.yaw);
    for (const ConvexPart& part : body.parts) {
        for (const Eigen::Vector3d& p : part.points) {
            const auto pixel = project_map_point(view, {pose.x + c * p.x() - s * p.y(), pose.y + s * p.x() + c * p.y(), p.z()});
            if (!pixel) return {};
            pixels.push_back(*pixel);
        }
    }
    const std::vector<Eigen::Vector2d> hull = hull_of(pixels);
    std::vector<Eigen::Vector2d> outline;
    const std::size_t step = hull.size() / 64 + 1;
    for (std::size_t i = 0; i < hull.size(); i += step) outline.push_back(hull[i]);
    return outline;
}

}  // namespace roomfix
