// A session's folder while it is being recorded.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "roomfix/base/result.hpp"
#include "roomfix/connect/frame_source.hpp"
#include "roomfix/connect/line_file.hpp"
#include "roomfix/observation/fix.hpp"
#include "roomfix/observation/odometry_observation.hpp"
#include "roomfix/observation/range_observation.hpp"
#include "roomfix/observation/sighting_observation.hpp"
#include "roomfix/observation/time_error.hpp"
#include "roomfix/site/site.hpp"

namespace roomfix {

/// A file of the site that a session needs a copy of.
struct CopiedFile {
    std::filesystem::path from;
    std::filesystem::path to;  // in the session's folder
};

/// What a session has beside what comes while it is recorded.
struct SessionContent {
    Site site;
    std::string site_yaml;             // with sources and files that lie in the session
    std::vector<std::string> cameras;  // ids of those whose frames are looked at
    std::vector<CopiedFile> files;
};

/// Writes one session. Frames appear whole, lines wait for `flush`; whatever ends the program, what was written before can be replayed.
class SessionWriter {
public:
    /// A new session in a folder that is empty or does not exist. `before`: a finished session of the same content, to share its files with.
    static Result<std::unique_ptr<SessionWriter>> create(const std::filesystem::path& folder, std::shared_ptr<const SessionContent> content,
                                                         const std::filesystem::path& before = {});

    Result<void> add_frame(const std::string& camera, Nanoseconds time, const TimeError& time_error, const PictureFile& picture);
    void add(const RangeObservation& range);
    void add(const RangeDifferenceObservation& difference);
    void add(const OdometryObservation& pose);
    void add(const SightingObservation& sighting);
    void add(const Fix& fix);
    /// The first thing that went wrong; the rest is tried all the same.
    Result<void> flush();
    /// Flushes, and takes away the mark that the session is not finished.
    Result<void> finish();

    /// All that it takes on the disk.
    std::int64_t bytes() const;
    /// That did not fit into memory while the disk took nothing.
    long lost_lines() const;
    /// That are not written yet; after finish(): that could not be.
    long waiting_lines() const;
    const std::filesystem::path& folder() const { return folder_; }

private:
    SessionWriter(std::filesystem::path folder, std::shared_ptr<const SessionContent> content) : folder_(std::move(folder)), content_(std::move(content)) {}
    struct LastFrame {
        Nanoseconds time = 0;
        TimeError time_error;
        std::optional<std::size_t> errors_file;  // its place in `lines_`
    };
    Result<void> make_folders();
    Result<void> copy_files(const std::filesystem::path& before);
    Result<void> make_line_files();
    Result<void> note_time_error(const std::string& camera, LastFrame& frame, const TimeError& error);

    std::filesystem::path folder_;
    std::shared_ptr<const SessionContent> content_;
    std::map<std::string, LastFrame> last_frame_;  // of each camera that gave one
    std::vector<LineFile> lines_;                  // in the order of `LineKind`, then those of the cameras
    bool range_differences_ = false;               // the columns that ranges.csv named last
    std::int64_t other_bytes_ = 0;
};

}  // namespace roomfix
