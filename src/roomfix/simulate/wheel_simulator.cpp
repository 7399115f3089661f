#include "roomfix/simulate/wheel_simulator.hpp"

#include <cmath>

#include "roomfix/base/random.hpp"
#include "roomfix/base/random_vector.hpp"

namespace roomfix {

std::vector<WheelPose> WheelSimulator::until(double time) {
    std::vector<WheelPose> poses;
    for (; static_cast<double>(next_) / model_.rate < time; ++next_) {
        const double now = static_cast<double>(next_) / model_.rate;
        if (next_ > 0) {
            const double step = 1 / model_.rate;
            const Pose2 from = true_pose_(now - step);
            const Pose2 to = true_pose_(now);
            Random random(mix64(seed_) + next_);
            Eigen::Vector2d way = Eigen::Rotation2Dd(-from.yaw) * Eigen::Vector2d(to.x - from.x, to.y - from.y);
            const double length = way.norm();
            double turned = wrap_angle(to.yaw - from.yaw);
            way += std::sqrt(length) * normal_vector<2>(random, {model_.along, model_.across});
            way /= 1 + model_.scale;
            turned += random.normal(model_.turn_per_metre * std::sqrt(length)) + random.normal(model_.turn_per_radian * std::sqrt(std::abs(turned)));
            turned -= model_.drift * step;
            const Eigen::Vector2d moved = Eigen::Rotation2Dd(reported_.yaw) * way;
            reported_ = {reported_.x + moved.x(), reported_.y + moved.y(), wrap_angle(reported_.yaw + turned)};
        }
        poses.push_back({now, reported_});
    }
    return poses;
}

}  // namespace roomfix
