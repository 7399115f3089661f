#include "roomfix/corner/chou1986.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

namespace roomfix {
namespace {

/// (1): the camera's axes in the corner's, as rows; before the swing.
Eigen::Matrix3d rotation(double psi, double theta) {
    Eigen::Matrix3d t;
    t << std::cos(psi), std::sin(psi), 0,                                                    //
        -std::sin(psi) * std::cos(theta), std::cos(psi) * std::cos(theta), std::sin(theta),  //
        -std::sin(psi) * std::sin(theta), std::cos(psi) * std::sin(theta), -std::cos(theta);
    return t;
}

/// The picture turned about its centre by `angle`.
Chou1986Line turned(const Chou1986Line& line, double angle) {
    const double cosine = std::cos(angle);
    const double sine = std::sin(angle);
    return {line.a * cosine + line.b * sine, -line.a * sine + line.b * cosine, line.c};
}

/// One root of (15) with the tilt that belongs to it, both up to half a turn.
struct SwingAndTilt {
    double delta, theta;
};

/// (14) to (16). With tan(delta) = c3 s the factor c3 leaves (15) where the third line runs along the v axis (a3 = 1, b3 = 0): a line
/// through the image centre, c3 = 0, is then no double root. The root is kept as a ratio p / q, so that it may be infinite.
std::vector<SwingAndTilt> swings_and_tilts(const std::array<Chou1986Line, 3>& l, double f) {
    const auto& [a1, b1, c1] = l[0];
    const auto& [a2, b2, c2] = l[1];
    const double c3 = l[2].c;
    const double ff = f * f;
    const double a = ff * c3 * c3 * b1 * b2 + c3 * c3 * c1 * c2 + ff * c3 * (c1 * a2 + c2 * a1) + ff * ff * (a1 * a2 + b1 * b2);  // A_delta
    const double b = ff * (c3 * (b1 * a2 + b2 * a1) - (c1 * b2 + c2 * b1));  // B_delta / c3; its second term is printed with a plus sign
    const double c = ff * a1 * a2 + c1 * c2;                                 // C_delta / c3^2
    const double discriminant = b * b - 4 * a * c;
    if (!(discriminant >= 0)) return {};
    const double h = -0.5 * (b + std::copysign(std::sqrt(discriminant), b));
    std::vector<SwingAndTilt> roots;
    for (const auto& [p, q] : {std::pair(h, a), std::pair(c, h)}) {
        const double delta = std::atan2(c3 * p, q);
        roots.push_back({delta, std::atan2(-q, f * p * std::cos(delta))});
    }
    return roots;
}

}  // namespace

std::vector<Chou1986Parameters> chou1986_closed_form(const std::array<Chou1986Line, 3>& lines, double f, double z_c) {
    // The picture is turned until the third line runs along the v axis; the swing of that picture is delta less the turn.
    const double turn = std::atan2(lines[2].b, lines[2].a);
    std::array<Chou1986Line, 3> l;
    for (std::size_t i = 0; i < 3; ++i) l[i] = turned(lines[i], turn);
    const double length = l[2].a;
    l[2] = {1, 0, l[2].c / length};
    const auto& [a1, b1, c1] = l[0];
    const auto& [a2, b2, c2] = l[1];
    std::vector<Chou1986Parameters> candidates;
    for (const auto& root : swings_and_tilts(l, f)) {
        // tan() tells each angle up to half a turn: all eight are kept.
        for (int half_turns = 0; half_turns < 8; ++half_turns) {
            const double delta = root.delta + (half_turns & 1 ? std::numbers::pi : 0);
            const double sd = std::sin(delta);
            const double cd = std::cos(delta);
            const double theta = root.theta + (half_turns & 2 ? std::numbers::pi : 0);
            const double st = std::sin(theta);
            const double ct = std::cos(theta);
            // (11) and (12): of the two the one that is farther from 0 / 0.
            const Eigen::Vector2d from_11(f * (b1 * sd + a1 * cd), f * b1 * ct * cd - f * a1 * ct * sd + c1 * st);
            const Eigen::Vector2d from_12(-(f * b2 * ct * cd - f * a2 * ct * sd + c2 * st), f * (b2 * sd + a2 * cd));
            const bool first = from_11.norm() * std::hypot(a2, b2) >= from_12.norm() * std::hypot(a1, b1);
            const double psi = (first ? std::atan2(from_11.x(), from_11.y()) : std::atan2(from_12.x(), from_12.y())) + (half_turns & 4 ? std::numbers::pi : 0);
            const double sp = std::sin(psi);
            const double cp = std::cos(psi);
            // (5) and (6) are two equations Z_c p = Y_c q, (7) and (8) two for X_c: least squares over each pair.
            const Eigen::Vector2d p_y(f * (-b1 * sp * cd + b1 * cp * ct * sd + a1 * sp * sd + a1 * cp * ct * cd),
                                      -c1 * sp * cd + c1 * cp * ct * sd + f * a1 * cp * st);
            const Eigen::Vector2d q_y(f * (a1 * st * cd + b1 * st * sd), -f * a1 * ct + c1 * st * sd);
            const Eigen::Vector2d p_x(f * (b2 * cp * cd + b2 * sp * ct * sd - a2 * cp * sd + a2 * sp * ct * cd),
                                      c2 * cp * cd + c2 * sp * ct * sd + f * a2 * sp * st);
            const Eigen::Vector2d q_x(-f * (a2 * st * cd + b2 * st * sd), f * a2 * ct - c2 * st * sd);
            candidates.push_back({psi, theta, delta + turn, z_c * p_x.dot(q_x) / q_x.squaredNorm(), z_c * p_y.dot(q_y) / q_y.squaredNorm()});
        }
    }
    return candidates;
}

std::optional<CornerView> chou1986_view(const CornerRays& rays) {
    // The paper's X axis is our y edge and its Y axis our x edge: with Z down, that is a right-handed system. Its v points up.
    constexpr std::array<CornerEdge, 3> axes = {y_edge, x_edge, wall_edge};
    std::array<Chou1986Line, 3> lines;
    for (std::size_t i = 0; i < 3; ++i) {
        const Eigen::Vector2d& d = rays.directions[axes[i]];
        lines[i] = {d.y(), d.x(), rays.corner.y() * d.x() - rays.corner.x() * d.y()};
    }
    std::optional<CornerView> best;
    double nearest = 1e-3;
    for (const Chou1986Parameters& p : chou1986_closed_form(lines, 1, 1)) {
        Eigen::Matrix3d camera = rotation(p.psi, p.theta);
        Eigen::Matrix3d swing;
        swing << std::cos(p.delta), -std::sin(p.delta), 0, std::sin(p.delta), std::cos(p.delta), 0, 0, 0, 1;
        camera = swing * camera;
        camera.row(1) *= -1;
        CornerView view;
        view.corner_from_camera.row(0) = camera.col(1).transpose();
        view.corner_from_camera.row(1) = camera.col(0).transpose();
        view.corner_from_camera.row(2) = -camera.col(2).transpose();
        view.place = {p.y_c, p.x_c};
        if (!view.place.allFinite() || !is_inside(view, std::numbers::pi / 2)) continue;
        const auto drawn = corner_rays(view, std::numbers::pi / 2);
        if (!drawn) continue;
        double miss = (drawn->corner - rays.corner).norm();
        for (std::size_t i = 0; i < 3; ++i) miss = std::max(miss, (drawn->directions[i] - rays.directions[i]).norm());
        if (miss < nearest) {
            nearest = miss;
            best = view;
        }
    }
    return best;
}

}  // namespace roomfix
