#include "roomfix/simulate/plane_picture.hpp"

#include <cmath>

#include "roomfix/base/random_vector.hpp"

namespace roomfix {

FlatPattern chessboard_pattern(int columns, int rows, double square) {
    constexpr float black = 0.08F, white = 0.9F, table = 0.35F;
    return [=](const Eigen::Vector2d& p) {
        const double u = p.x() / square + 1, v = p.y() / square + 1;  // squares from the board's own corner
        if (u < -1 || v < -1 || u > columns + 2 || v > rows + 2) return table;
        if (u < 0 || v < 0 || u > columns + 1 || v > rows + 1) return white;
        return (static_cast<int>(u) + static_cast<int>(v)) % 2 == 0 ? black : white;
    };
}

PlanePictures::PlanePictures(const CameraModel& camera, const SensorModel& sensor, std::uint64_t seed)
    : width_(camera.width), height_(camera.height), seed_(seed), sensor_(camera.width, camera.height, sensor, {.part = 0}, seed), rays_(camera) {}

void PlanePictures::render(const FlatPattern& pattern, const Eigen::Isometry3d& camera_from_plane, std::uint64_t index, LumaImage& picture,
                           const SheetHeight& height, const Vector6d& motion) {
    std::vector<Eigen::Isometry3d> plane_from_camera;  // of each row, and below the last
    for (int y = 0; y <= height_; ++y) {
        const double late = (y + 0.5) / height_ - 0.5;
        plane_from_camera.push_back(perturbed(camera_from_plane, late * motion).inverse(Eigen::Isometry));
    }
    const auto light_along = [&](const Eigen::Vector3f& ray, std::size_t row) {
        const Eigen::Vector3d eye = plane_from_camera[row].translation(), way = plane_from_camera[row].linear() * ray.cast<double>();
        double along = -eye.z() / way.z();
        constexpr int rounds = 2;  // the height hardly changes from one to the next
        for (int i = 0; height && i < rounds; ++i) along = (height((eye + along * way).head<2>()) - eye.z()) / way.z();
        return along > 0 ? pattern((eye + along * way).head<2>()) : 0.0F;
    };
    std::vector<float> at_corners;
    at_corners.reserve(rays_.corners().size());
    for (const Eigen::Vector3f& ray : rays_.corners()) at_corners.push_back(light_along(ray, at_corners.size() / rays_.stride()));
    light_.assign(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_), 0);
    Random random(seed_ ^ 0x5ab5);
    for (int y = 0; y < height_; ++y) {
        const auto row = static_cast<std::size_t>(y);
        for (int x = 0; x < width_; ++x) {
            const std::size_t top = rays_.corner(x, y), bottom = top + rays_.stride();
            float& out = light_[row * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x)];
            const float first = at_corners[top];
            const bool plain = first == at_corners[top + 1] && first == at_corners[bottom] && first == at_corners[bottom + 1] &&
                               first == light_along(rays_.within(x, y, 0.5F, 0.5F), row);
            if (plain) {
                out = first;
                continue;
            }
            // Anywhere in each cell of the pixel: rays in rows would move edges that run along them.
            for (int j = 0; j < fine; ++j) {
                for (int i = 0; i < fine; ++i) {
                    const auto u = static_cast<float>((i + random.uniform()) / fine), v = static_cast<float>((j + random.uniform()) / fine);
                    out += light_along(rays_.within(x, y, u, v), row) / (fine * fine);
                }
            }
        }
    }
    sensor_.blur(light_);
    sensor_.expose(light_, 1);
    sensor_.take(light_, index, picture);
}

std::vector<Eigen::Isometry3d> board_poses(const CameraModel& camera, const Eigen::Vector2d& size, int count, Random& random) {
    std::vector<Eigen::Isometry3d> poses;
    const double focal = std::sqrt(camera.fx * camera.fy);
    while (static_cast<int>(poses.size()) < count) {
        const double part = random.uniform(0.3, 0.75);  // of the picture's height that the board takes
        const double distance = focal * size.maxCoeff() / (part * camera.height);
        const Eigen::Vector2d pixel = uniform2(random, {0, 0}, {camera.width - 1.0, camera.height - 1.0});
        const auto ray = unproject(camera, pixel);
        if (!ray) continue;
        Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
        const double towards = random.uniform(0, 2 * std::numbers::pi), tilt = radians(random.uniform(5, 45));
        const double quarter_turns = std::floor(random.uniform(0, 4));
        // Tilted against the ray, not against the picture: a board is shown with its front.
        pose.linear() = Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), ray->homogeneous()).toRotationMatrix() *
                        exponential_rotation(tilt * Eigen::Vector3d(std::cos(towards), std::sin(towards), 0)) *
                        exponential_rotation((quarter_turns * std::numbers::pi / 2 + random.uniform(-0.5, 0.5)) * Eigen::Vector3d::UnitZ());
        pose.translation() = distance * ray->homogeneous() - pose.linear() * Eigen::Vector3d(size.x() / 2, size.y() / 2, 0);
        bool in_sight = true;
        const double margin = 0.12 * size.maxCoeff();
        for (const double u : {-margin, size.x() / 2, size.x() + margin}) {
            for (const double v : {-margin, size.y() / 2, size.y() + margin}) {
                const auto seen = project(camera, pose * Eigen::Vector3d(u, v, 0));
                in_sight = in_sight && seen && camera.contains(*seen, 4);
            }
        }
        if (in_sight) poses.push_back(pose);
    }
    return poses;
}

}  // namespace roomfix
