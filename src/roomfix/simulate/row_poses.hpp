// Where a camera is while its picture's rows are exposed.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <span>

namespace roomfix {

/// map_from_camera of each row; or a single one, where all rows are exposed at once.
class RowPoses {
public:
    RowPoses(const Eigen::Isometry3d& of_all) : poses_(&of_all, 1) {}  // NOLINT(google-explicit-constructor): a pose is the usual case
    explicit RowPoses(std::span<const Eigen::Isometry3d> of_each) : poses_(of_each) {}

    bool all_at_once() const { return poses_.size() == 1; }
    const Eigen::Isometry3d& of(int row) const { return poses_[static_cast<std::size_t>(std::clamp(row, 0, static_cast<int>(poses_.size()) - 1))]; }

private:
    std::span<const Eigen::Isometry3d> poses_;
};

}  // namespace roomfix
