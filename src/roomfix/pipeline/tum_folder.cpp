#include "roomfix/pipeline/tum_folder.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "roomfix/base/number.hpp"
#include "roomfix/observation/tum_line.hpp"

namespace roomfix {

Result<std::unique_ptr<TumFolder>> TumFolder::open(const std::string& folder) {
    std::error_code failure;
    std::filesystem::create_directories(folder, failure);
    if (!std::filesystem::is_directory(folder, failure))
        return Error{fmt::format("{}: cannot be made a folder for TUM files: check that its own folder exists", folder)};
    return std::unique_ptr<TumFolder>(new TumFolder(folder));
}

TumFolder::Files& TumFolder::files_of(const std::string& robot) {
    const auto [found, is_new] = files_.try_emplace(robot);
    if (is_new) {
        found->second.way.open(folder_ / (robot + ".tum"), std::ios::binary | std::ios::app);
        found->second.covariances.open(folder_ / (robot + ".cov"), std::ios::binary | std::ios::app);
    }
    return found->second;
}

Result<void> TumFolder::give(const FixBatch& batch) {
    bool written = true;
    for (const Fix& fix : batch.given) {
        if (fix.status == FixStatus::none || fix.unknown || fix.robot.empty()) continue;
        Files& files = files_of(fix.robot);
        files.way << tum_line(fix.time, fix.pose, fix.yaw_known) << std::flush;
        files.covariances << fmt::format("{} {} {} {}", seconds_text(fix.time), number_text(fix.pose.x), number_text(fix.pose.y),
                                         number_text(fix.yaw_known ? fix.pose.yaw : 0));
        for (int i = 0; i < 3; ++i) {
            for (int j = i; j < 3; ++j) files.covariances << ' ' << number_text(fix.covariance(i, j));
        }
        files.covariances << std::endl;
        written = written && files.way && files.covariances;
        files.way.clear();
        files.covariances.clear();
    }
    // Of many robots that are alike each new one gets a new name.
    std::erase_if(
        files_, [&](const auto& robot) { return std::none_of(batch.all.begin(), batch.all.end(), [&](const Fix& fix) { return fix.robot == robot.first; }); });
    if (written) return {};
    return Error{fmt::format("{}: poses could not be written and are lost: is the disk full?", name())};
}

}  // namespace roomfix
