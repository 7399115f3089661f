#include "roomfix/connect/session_writer.hpp"

#include <fmt/format.h>

#include "roomfix/connect/fix_json.hpp"
#include "roomfix/connect/sensed_lines.hpp"
#include "roomfix/connect/time_errors.hpp"

namespace roomfix {
namespace {

namespace fs = std::filesystem;

/// The files that grow, by their places in `lines_`.
enum LineKind : std::size_t { ranges, odometry, sightings, fixes };

}  // namespace

Result<std::unique_ptr<SessionWriter>> SessionWriter::create(const fs::path& folder, std::shared_ptr<const SessionContent> content, const fs::path& before) {
    std::unique_ptr<SessionWriter> writer(new SessionWriter(folder, std::move(content)));
    if (auto made = writer->make_folders(); !made) return made.error();
    if (auto copied = writer->copy_files(before); !copied) return copied.error();
    if (auto made = writer->make_line_files(); !made) return made.error();
    // The last file: a folder that has it is a session.
    if (auto written = write_whole(folder / "site.yaml", writer->content_->site_yaml); !written) return written.error();
    writer->other_bytes_ += static_cast<std::int64_t>(writer->content_->site_yaml.size());
    return writer;
}

Result<void> SessionWriter::make_folders() {
    std::error_code failure;
    fs::create_directories(folder_, failure);
    for (const std::string& camera : content_->cameras) {
        if (!failure) fs::create_directories(folder_ / "frames" / camera, failure);
    }
    if (failure) return Error{fmt::format("{}: no session can be made there ({}): check the disk and the permissions", folder_.string(), failure.message())};
    for (const std::string& camera : content_->cameras) {
        if (auto written = write_whole(folder_ / "frames" / camera / no_frames_mark, ""); !written) return written;
    }
    return write_whole(folder_ / unfinished_mark, "");
}

/// A file that the session before has already is the same file under a second name, where the disk can do that.
Result<void> SessionWriter::copy_files(const fs::path& before) {
    for (const CopiedFile& file : content_->files) {
        const fs::path target = folder_ / file.to;
        std::error_code failure;
        fs::create_directories(target.parent_path(), failure);
        fs::remove(target, failure);  // of an attempt that went wrong
        const bool shared = !before.empty() && fs::exists(before / file.to, failure);
        if (shared) fs::create_hard_link(before / file.to, target, failure);
        if (!shared || failure) fs::copy_file(shared ? before / file.to : file.from, target, fs::copy_options::overwrite_existing, failure);
        if (failure) return Error{fmt::format("{}: cannot be copied to {}: {}", file.from.string(), target.string(), failure.message())};
        other_bytes_ += static_cast<std::int64_t>(fs::file_size(target, failure));
    }
    return {};
}

Result<void> SessionWriter::make_line_files() {
    using Begin = std::pair<const char*, std::string_view>;
    for (const auto& [name, columns] :
         {Begin{"ranges.csv", range_columns}, Begin{"odometry.csv", odometry_columns}, Begin{"sightings.csv", sighting_columns}, Begin{"fixes.jsonl", ""}}) {
        auto file = LineFile::create(folder_ / name, columns);
        if (!file) return file.error();
        lines_.push_back(std::move(*file));
    }
    return {};
}

Result<void> SessionWriter::add_frame(const std::string& camera, Nanoseconds time, const TimeError& time_error, const PictureFile& picture) {
    const fs::path frames = folder_ / "frames" / camera;
    const auto last = last_frame_.find(camera);
    if (last != last_frame_.end() && last->second.time == time) {
        return Error{fmt::format("camera {}: two frames have the same time: the second one is not recorded; check the camera's clock", camera)};
    }
    if (auto written = write_whole(frames / fmt::format("{:012}.{}", time, picture.ending), picture.bytes); !written) return written;
    std::error_code failure;
    if (last == last_frame_.end()) fs::remove(frames / no_frames_mark, failure);
    LastFrame& frame = last_frame_[camera];
    frame.time = time;
    other_bytes_ += static_cast<std::int64_t>(picture.bytes.size());
    return note_time_error(camera, frame, time_error);
}

/// Only what changes is written. Without a line the time is right.
Result<void> SessionWriter::note_time_error(const std::string& camera, LastFrame& frame, const TimeError& error) {
    if (error == frame.time_error) return {};
    if (!frame.errors_file) {
        auto file = LineFile::create(folder_ / "frames" / camera / time_errors_name, time_error_columns);
        if (!file) return file.error();
        frame.errors_file = lines_.size();
        lines_.push_back(std::move(*file));
    }
    frame.time_error = error;
    lines_[*frame.errors_file].add(time_error_line({frame.time, error}));
    return {};
}

void SessionWriter::add(const RangeObservation& range) {
    if (range_differences_) lines_[ranges].add(range_columns);
    range_differences_ = false;
    lines_[ranges].add(sensed_line(range, content_->site));
}

void SessionWriter::add(const RangeDifferenceObservation& difference) {
    if (!range_differences_) lines_[ranges].add(range_difference_columns);
    range_differences_ = true;
    lines_[ranges].add(sensed_line(difference, content_->site));
}

void SessionWriter::add(const OdometryObservation& pose) { lines_[odometry].add(sensed_line(pose, content_->site)); }
void SessionWriter::add(const SightingObservation& sighting) { lines_[sightings].add(sensed_line(sighting, content_->site)); }
void SessionWriter::add(const Fix& fix) { lines_[fixes].add(fix_line(fix) + '\n'); }

Result<void> SessionWriter::flush() {
    Result<void> first;
    for (LineFile& file : lines_) {
        if (auto flushed = file.flush(); !flushed && first) first = flushed;
    }
    return first;
}

Result<void> SessionWriter::finish() {
    if (auto flushed = flush(); !flushed) return flushed;
    std::error_code failure;
    fs::remove(folder_ / unfinished_mark, failure);
    if (failure) return Error{fmt::format("{}: cannot be removed ({})", (folder_ / unfinished_mark).string(), failure.message())};
    return {};
}

std::int64_t SessionWriter::bytes() const {
    std::int64_t sum = other_bytes_;
    for (const LineFile& file : lines_) sum += file.bytes();
    return sum;
}

long SessionWriter::waiting_lines() const {
    long sum = 0;
    for (const LineFile& file : lines_) sum += file.waiting_lines();
    return sum;
}

long SessionWriter::lost_lines() const {
    long sum = 0;
    for (const LineFile& file : lines_) sum += file.lost_lines();
    return sum;
}

}  // namespace roomfix
