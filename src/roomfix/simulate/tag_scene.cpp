#include "roomfix/simulate/tag_scene.hpp"

#include <algorithm>
#include <cmath>

#include "roomfix/base/random.hpp"
#include "roomfix/imaging/tag_detector.hpp"

namespace roomfix {
namespace {

constexpr int samples = 64;     // per pixel: a low-discrepancy sequence, so that edges along the rows are as smooth as others
constexpr double spread = 2.2;  // px: a pixel's light comes from a square of this size
constexpr double black = 25;    // grey levels
constexpr double white = 200;

}  // namespace

void paint_tag(const View& view, const Eigen::Isometry3d& map_from_tag, const Tag& tag, double noise, std::uint64_t index, LumaImage& frame) {
    const auto [bits, square] = tag_picture(tag.family, tag.number);
    const double bit = tag.size / square;
    const double half = 0.5 * bits.width() * bit;
    Eigen::AlignedBox2d box;
    for (const auto& [x, y] : {std::pair{-half, -half}, {half, -half}, {half, half}, {-half, half}}) {
        const auto pixel = project_map_point(view, map_from_tag * Eigen::Vector3d(x, y, 0));
        if (!pixel) return;
        box.extend(*pixel);
    }
    const Eigen::Isometry3d tag_from_map = map_from_tag.inverse();
    const Eigen::Vector3d eye = tag_from_map * view.position();
    if (eye.z() <= 0) return;
    const Eigen::Matrix3d tag_from_camera = tag_from_map.linear() * view.map_from_camera.pose.linear();
    Random random(index ^ 0x7a9);
    for (int v = std::max(static_cast<int>(box.min().y()) - 2, 0); v <= std::min(static_cast<int>(box.max().y()) + 2, frame.height() - 1); ++v) {
        for (int u = std::max(static_cast<int>(box.min().x()) - 2, 0); u <= std::min(static_cast<int>(box.max().x()) + 2, frame.width() - 1); ++u) {
            double sum = 0;
            for (int i = 0; i < samples; ++i) {
                constexpr double step_x = 0.7548776662466927, step_y = 0.5698402909980532;  // powers of the plastic number's inverse
                const double x = u + spread * (std::fmod(0.5 + i * step_x, 1) - 0.5);
                const double y = v + spread * (std::fmod(0.5 + i * step_y, 1) - 0.5);
                const auto ray = unproject(view.model, {x, y});
                if (!ray) continue;
                const Eigen::Vector3d direction = tag_from_camera * ray->homogeneous();
                const Eigen::Vector2d place = eye.head<2>() - direction.head<2>() * (eye.z() / direction.z());
                const bool ahead = direction.z() < 0;
                const int column = static_cast<int>(std::floor((place.x() + half) / bit));
                const int row = static_cast<int>(std::floor((half - place.y()) / bit));
                const bool on_paper = ahead && column >= 0 && row >= 0 && column < bits.width() && row < bits.height();
                sum += on_paper ? (bits.row(row)[column] > 127 ? white : black) : frame.row(v)[u];
            }
            const double grey = sum / samples;
            frame.row(v)[u] = static_cast<std::uint8_t>(std::clamp(std::lround(grey + random.normal(noise)), 0L, 255L));
        }
    }
}

}  // namespace roomfix
