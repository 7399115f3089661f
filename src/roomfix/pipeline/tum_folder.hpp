// Each robot's way in files that the tool evo reads.
#pragma once

#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <string>

#include "roomfix/pipeline/fix_sink.hpp"

namespace roomfix {

/// FOLDER/ROBOT.tum with a line per fix, and beside it FOLDER/ROBOT.cov with what that format has no room for: "time x y yaw", then the covariance's upper
/// triangle row by row over x, y, yaw (s, m, rad).
class TumFolder final : public FixSink {
public:
    /// Makes the folder; what is in its files stays. An error if that cannot be.
    static Result<std::unique_ptr<TumFolder>> open(const std::string& folder);
    std::string name() const override { return folder_.string(); }
    Result<void> give(const FixBatch& batch) override;

private:
    struct Files {
        std::ofstream way, covariances;
    };
    explicit TumFolder(std::filesystem::path folder) : folder_(std::move(folder)) {}
    Files& files_of(const std::string& robot);

    std::filesystem::path folder_;
    std::map<std::string, Files> files_;
};

}  // namespace roomfix
