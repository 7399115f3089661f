// The sessions of a recording: one, or parts of which the oldest go.
#pragma once

#include <cstdint>
#include <deque>
#include <filesystem>
#include <memory>

#include "roomfix/connect/session_writer.hpp"

namespace roomfix {

/// How much of a recording is kept; 0: all. With a limit the recording is made of parts of a tenth of it.
struct RecordingLimits {
    double minutes = 0;    // of the clock
    double gigabytes = 0;  // 1e9 bytes

    bool any() const { return minutes > 0 || gigabytes > 0; }
};

class SessionParts {
public:
    /// `folder` becomes the session, or with limits holds part-0001, part-0002, ..., each a whole session.
    SessionParts(std::filesystem::path folder, std::shared_ptr<const SessionContent> content, const RecordingLimits& limits)
        : folder_(std::move(folder)), content_(std::move(content)), limits_(limits) {}

    /// The session that is written at `now` (s of the clock): goes on to the next part and removes the oldest where it is time. An error where a part
    /// cannot be made; the next call tries again.
    Result<SessionWriter*> current(double now);
    Result<void> flush();
    Result<void> finish();
    std::int64_t bytes() const;
    long lost_lines() const { return lost_lines_ + (writer_ ? writer_->lost_lines() : 0); }

private:
    struct Part {
        std::filesystem::path folder;
        std::int64_t bytes = 0;
        double end = 0;  // s of the clock
    };
    bool is_full(double now) const;
    Result<void> begin(double now);
    Result<void> end_part(double now);
    void remove_oldest(double now);

    std::filesystem::path folder_;
    std::shared_ptr<const SessionContent> content_;
    RecordingLimits limits_;
    std::unique_ptr<SessionWriter> writer_;
    double begun_ = 0;        // s of the clock, of the current part
    int number_ = 0;          // of the current part
    std::deque<Part> ended_;  // oldest first
    long lost_lines_ = 0;     // of parts that have ended, and those that the last one could not write in the end
};

}  // namespace roomfix
