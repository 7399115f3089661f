// Corners under a moulding of which the site tells, or does not tell: where is the camera, and how well is that known?
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "roomfix/base/random.hpp"
#include "roomfix/corner/corner_locator.hpp"
#include "roomfix/simulate/room_shots.hpp"
#include "roomfix/geometry/view.hpp"

namespace roomfix {
namespace {

enum class Moulded { no_wall, one_wall, both_walls };
enum class Measured { at_ceiling, at_lower_edge };

struct Figures {
    int pictures = 0, fixes = 0;
    int astray = 0;   // of the fixes: farther off than 4 of the standard deviations that they state
    int sharp = 0;    // that state less than 1 % of the distance to the corner
    int sharply_wrong = 0; // that state less than 1 % and are off by more than 2 %
    int several = 0;  // with several places
    double off = 0, stated = 0;  // of the distance to the corner: means
    double largest = 0;
};

struct Study {
    Moulded moulded = Moulded::both_walls;
    Measured measured = Measured::at_ceiling;
    bool stated = false;
    bool furnished = false;
};

Figures look(const Study& study, std::uint64_t seed, int pictures) {
    const CameraModel model = room_camera();
    RoomRenderer renderer(model, room_sensor(), {}, seed);
    CornerObserver observer(model, {std::numbers::pi / 2});
    Random random(seed);
    LumaImage frame;
    CornerResult seen;
    Figures figures;
    for (int i = 0; i < pictures; ++i) {
        RoomShot shot = study.furnished ? cluttered_shot(random) : chou1986_shot(chou1986_places()[static_cast<std::size_t>(i) % 16], random);
        shot.scene.moulding = study.moulded == Moulded::no_wall ? 0 : random.uniform(0.05, 0.12);
        shot.scene.moulding_slope = random.uniform(0.1, 1);
        shot.scene.moulding_albedo = static_cast<float>(random.uniform(0.75, 0.92));
        if (study.moulded == Moulded::one_wall) {
            shot.scene.moulded.assign(4, false);
            shot.scene.moulded[random.index(2) == 0 ? 0 : 3] = true;
        }
        Site site;
        SiteCorner corner{"c", {0, 0, shot.scene.height}, 0};
        if (study.measured == Measured::at_lower_edge) corner.position.z() -= shot.scene.moulding;
        if (study.stated) corner.moulding = shot.scene.moulding;
        site.corners = {corner};
        const double height = shot.map_from_camera.translation().z();
        site.cameras = {SiteCamera{"eye", "frames", model, KnownHeight{height, 0.005, ""}, ""}};
        const auto locator = CornerLocator::for_camera(site, site.cameras[0]);
        renderer.render(shot.scene, shot.map_from_camera, shot.light, static_cast<std::uint64_t>(i), frame);
        observer.observe(frame, {}, seen);
        LocatedCamera located;
        locator->locate(seen.corners, {}, located);
        ++figures.pictures;
        if (located.places.empty()) continue;
        ++figures.fixes;
        const CameraPlace& best = located.places[0];
        const Eigen::Vector2d off = shot.map_from_camera.translation().head<2>() - Eigen::Vector2d(best.pose.x, best.pose.y);
        const Eigen::Matrix2d covariance = best.covariance.topLeftCorner<2, 2>();
        const double distance = (shot.map_from_camera.translation() - corner.position).norm();
        const double part = off.norm() / distance;
        const double stated = std::sqrt(covariance.trace()) / distance;
        figures.off += part;
        figures.stated += stated;
        figures.largest = std::max(figures.largest, part);
        figures.astray += off.dot(covariance.ldlt().solve(off)) > 16;
        figures.sharp += stated < 0.01;
        figures.sharply_wrong += stated < 0.01 && part > 0.02;
        figures.several += located.places.size() > 1;
        if (std::getenv("VERBOSE")) {
            fmt::print("  {:2} m {:.3f} slope {:.2f} place {:.1f} {:.1f}: off {:.2f} % stated {:.2f} %", i, shot.scene.moulding, shot.scene.moulding_slope,
                       shot.map_from_camera.translation().x(), shot.map_from_camera.translation().y(), 100 * part, 100 * stated);
            for (const auto& p : located.places) fmt::print(" | {:.3f} {:.3f} w {:.2f}", p.pose.x, p.pose.y, p.weight);
            const View view{model, {shot.map_from_camera, Matrix6d::Zero()}};
            const Eigen::Vector2d at = seen.corners[static_cast<std::size_t>(best.observation)].pixel.cast<double>();
            const double m = shot.scene.moulding, p = m * shot.scene.moulding_slope, H = shot.scene.height;
            const bool wall0 = shot.scene.moulded.empty() || shot.scene.moulded[0];
            for (const Eigen::Vector3d& q : {Eigen::Vector3d(0, 0, H), Eigen::Vector3d(0, 0, H - m), wall0 ? Eigen::Vector3d(0, p, H) : Eigen::Vector3d(p, 0, H)}) {
                fmt::print(" [{:.1f}]", (project_map_point(view, q).value_or(Eigen::Vector2d::Zero()) - at).norm());
            }
            fmt::print(" wall {} turned {:.2f} deg, kind {} seen", wall0 ? 0 : 3,
                       degrees(Eigen::AngleAxisd(Eigen::Matrix3d(shot.map_from_camera.linear().transpose() * best.map_from_camera.pose.linear())).angle()), 0);
            for (const auto& e : seen.corners[static_cast<std::size_t>(best.observation)].edges) fmt::print(" {:.0f}/{:.0f}", e.seen, e.visible);
            fmt::print("\n");
        }
    }
    figures.off /= std::max(figures.fixes, 1);
    figures.stated /= std::max(figures.fixes, 1);
    return figures;
}

TEST(Moulding, Figures) {
    const char* text = std::getenv("PICTURES");
    const int pictures = text ? std::atoi(text) : 16;
    for (const bool furnished : {false, true}) {
        for (const Moulded moulded : {Moulded::no_wall, Moulded::one_wall, Moulded::both_walls}) {
            for (const Measured measured : {Measured::at_ceiling, Measured::at_lower_edge}) {
                for (const bool stated : {false, true}) {
                    if (moulded == Moulded::no_wall && (stated || measured == Measured::at_lower_edge)) continue;
                    if (stated && measured == Measured::at_lower_edge) continue;
                    const Figures f = look({moulded, measured, stated, furnished}, 71, pictures);
                    fmt::print("{:9} moulding on {:5}, measured {:13} {:8}: {:3} of {:3} fixes, off {:5.2f} % (largest {:6.2f} %), states {:5.2f} %, astray {:3}, sharp {:3}, "
                               "sharply wrong {:3}, several {:3}\n",
                               furnished ? "furnished" : "bare", moulded == Moulded::no_wall ? "none" : moulded == Moulded::one_wall ? "one" : "both",
                               measured == Measured::at_ceiling ? "at ceiling" : "at lower edge", stated ? "stated" : "unstated", f.fixes, f.pictures, 100 * f.off,
                               100 * f.largest, 100 * f.stated, f.astray, f.sharp, f.sharply_wrong, f.several);
                }
            }
        }
    }
}

}  // namespace
}  // namespace roomfix
