#include "roomfix/ceiling/kim2011.hpp"

#include <algorithm>
#include <cmath>

namespace roomfix {

Kim2011::Kim2011(const SiteLandmark& landmark, const Mount& mount, const Kim2011Settings& settings)
    : triangle_(std::get<LedTriangle>(landmark.kind)),
      map_from_landmark_(landmark.map_from_landmark),
      robot_from_camera_(mount.robot_from_camera.pose.linear()),
      settings_(settings) {}

/// Binary picture and Grassfire labelling: each bright pixel not yet labelled sets fire to its neighbours.
void Kim2011::label(LumaView frame) {
    areas_.clear();
    open_.assign(static_cast<std::size_t>(frame.width * frame.height), 0);
    for (int y = 0; y < frame.height; ++y) {
        for (int x = 0; x < frame.width; ++x) open_[static_cast<std::size_t>(y * frame.width + x)] = frame.at(x, y) > settings_.threshold;
    }
    std::vector<std::pair<int, int>> burning;
    for (int y = 0; y < frame.height; ++y) {
        for (int x = 0; x < frame.width; ++x) {
            if (!open_[static_cast<std::size_t>(y * frame.width + x)]) continue;
            Area area;
            burning.assign(1, {x, y});
            open_[static_cast<std::size_t>(y * frame.width + x)] = 0;
            while (!burning.empty()) {
                const auto [u, v] = burning.back();
                burning.pop_back();
                ++area.count;
                area.sum += Eigen::Vector2d(u, v);
                area.pixels.emplace_back(u, v);
                for (int j = std::max(v - 1, 0); j <= std::min(v + 1, frame.height - 1); ++j) {
                    for (int i = std::max(u - 1, 0); i <= std::min(u + 1, frame.width - 1); ++i) {
                        char& fuel = open_[static_cast<std::size_t>(j * frame.width + i)];
                        if (fuel) burning.emplace_back(i, j);
                        fuel = 0;
                    }
                }
            }
            areas_.push_back(std::move(area));
        }
    }
}

/// Large areas are lamps. They are split into pieces, so that the window around a slanted tube does not cover half the picture
/// (Figs. 11, 12), and each piece's window is expanded (Fig. 10).
std::vector<Kim2011::Window> Kim2011::lamp_windows() const {
    std::vector<Window> windows;
    for (const Area& area : areas_) {
        if (area.count <= settings_.largest) continue;
        std::vector<std::pair<std::pair<int, int>, Window>> pieces;
        for (const auto& [x, y] : area.pixels) {
            const std::pair<int, int> cell{x / settings_.segment, y / settings_.segment};
            auto piece = std::find_if(pieces.begin(), pieces.end(), [&](const auto& p) { return p.first == cell; });
            if (piece == pieces.end()) piece = pieces.insert(pieces.end(), {cell, {x, y, x, y}});
            Window& w = piece->second;
            w = {std::min(w.left, x), std::min(w.top, y), std::max(w.right, x), std::max(w.bottom, y)};
        }
        const int e = settings_.expansion;
        for (const auto& [cell, w] : pieces) windows.push_back({w.left - e, w.top - e, w.right + e, w.bottom + e});
    }
    return windows;
}

/// Centres of the areas of a LED's size outside all lamps' windows: Kim (1).
std::vector<Eigen::Vector2d> Kim2011::candidates() const {
    const auto windows = lamp_windows();
    std::vector<Eigen::Vector2d> centres;
    for (const Area& area : areas_) {
        if (area.count < settings_.smallest || area.count > settings_.largest) continue;
        const Eigen::Vector2d centre = area.sum / area.count;
        const auto holds = [&](const Window& w) { return centre.x() >= w.left && centre.x() <= w.right && centre.y() >= w.top && centre.y() <= w.bottom; };
        if (std::none_of(windows.begin(), windows.end(), holds)) centres.push_back(centre);
    }
    return centres;
}

/// The paper does not say how three of the candidates are chosen; here: the triple whose side ratios fit best.
std::optional<std::array<Eigen::Vector2d, 3>> Kim2011::landmark_among(const std::vector<Eigen::Vector2d>& centres) const {
    const double hypotenuse = std::hypot(triangle_.a, triangle_.b);
    double best = settings_.shape_tolerance;
    std::optional<std::array<Eigen::Vector2d, 3>> found;
    for (std::size_t i = 0; i < centres.size(); ++i) {
        for (std::size_t j = 0; j < centres.size(); ++j) {
            for (std::size_t k = 0; k < centres.size(); ++k) {
                if (i == j || i == k || j == k) continue;
                const Eigen::Vector2d a = centres[j] - centres[i];
                const Eigen::Vector2d b = centres[k] - centres[i];
                const double scale = (b - a).norm() / hypotenuse;
                // Seen from below, with the camera's own handedness.
                const double turn = robot_from_camera_.row(2).z() * (a.x() * b.y() - a.y() * b.x());
                if (!(scale > 0) || (b - a).norm() > settings_.longest || turn <= 0) continue;
                const double misfit = std::max(std::abs(a.norm() / (scale * triangle_.a) - 1), std::abs(b.norm() / (scale * triangle_.b) - 1));
                if (misfit < best) {
                    best = misfit;
                    found = {{centres[i], centres[j], centres[k]}};
                }
            }
        }
    }
    return found;
}

std::optional<Kim2011Fix> Kim2011::locate(LumaView frame, std::optional<double> distance, double height, std::string* reason) {
    const auto give_up = [&](const char* why) {
        if (reason) *reason = why;
        return std::nullopt;
    };
    label(frame);
    const auto leds = landmark_among(candidates());
    if (!leds) return give_up("the published method found no right triangle among the bright areas");
    const Eigen::Vector2d& l1 = (*leds)[1];
    const Eigen::Vector2d& l3 = (*leds)[2];
    const Eigen::Vector2d l_c = 0.5 * (l1 + l3);                                    // Kim (2)
    const Eigen::Vector2d i_c(0.5 * (frame.width - 1), 0.5 * (frame.height - 1));   // "nearly matched" to the robot
    double dist_c2s = (l_c - i_c).norm();                                           // Kim (3)
    const double angl_c2s = std::atan2(l_c.y() - i_c.y(), l_c.x() - i_c.x());       // Kim (4)
    const double s_land = std::hypot(triangle_.a, triangle_.b) / (l1 - l3).norm();  // Kim (5')

    Kim2011Fix fix;
    double s = s_land;
    if (distance) {
        const double r_k = std::sqrt(std::max(*distance * *distance - height * height, 0.0));  // Kim (8)
        const double from_range = r_k / s_land;
        const bool at_edge = dist_c2s > settings_.edge * 0.5 * std::min(frame.width, frame.height);
        if (at_edge && std::abs(dist_c2s - from_range) > settings_.edge_threshold * dist_c2s) dist_c2s = 0.5 * (dist_c2s + from_range);
        // Kim (5) divides by dist_c2s, which is 0 right under the landmark: s_LAND there.
        fix.used_range = dist_c2s > 0 && std::abs(r_k - s_land * dist_c2s) < settings_.rule;  // Kim (7)
        if (fix.used_range) s = r_k / dist_c2s;                                               // Kim (5)
    }
    // Heading: the hypotenuse's slope on the robot against that in the map; the right angle told which end is which.
    const auto on_robot = [&](const Eigen::Vector2d& d) { return Eigen::Vector2d((robot_from_camera_ * Eigen::Vector3d(d.x(), d.y(), 0)).head<2>()); };
    const Eigen::Vector2d seen = on_robot(l3 - l1);
    const Eigen::Vector3d known = map_from_landmark_.linear() * Eigen::Vector3d(-triangle_.a, triangle_.b, 0);
    fix.pose.yaw = wrap_angle(std::atan2(known.y(), known.x()) - std::atan2(seen.y(), seen.x()));
    // Kim (6), with angl_c2s turned into the map's axes by the heading, which print leaves out.
    const Eigen::Vector2d towards = Eigen::Rotation2Dd(fix.pose.yaw) * on_robot({std::cos(angl_c2s), std::sin(angl_c2s)});
    const Eigen::Vector2d place = map_from_landmark_.translation().head<2>() - dist_c2s * s * towards;
    fix.pose.x = place.x();
    fix.pose.y = place.y();
    return fix;
}

}  // namespace roomfix
