// Records what a site's sources give, as a session that can be replayed, in a thread of its own.
#pragma once

#include <condition_variable>
#include <deque>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <variant>

#include "roomfix/connect/frame_source.hpp"
#include "roomfix/pipeline/fix_sink.hpp"
#include "roomfix/pipeline/session_parts.hpp"
#include "roomfix/pipeline/site_tracker.hpp"

namespace roomfix {

struct RecorderSettings {
    std::filesystem::path folder;
    RecordingLimits limits;
    bool wait = false;                                   // nothing may be lost: who gives more than can be written waits
    std::function<void(const std::string&)> on_trouble;  // a sentence when recording fails or goes on again; from any thread
};

struct RecordingState {
    bool ok = true;
    std::string message;  // what is wrong now; empty: nothing
    long frames = 0;      // recorded
    long lost = 0;        // frames, readings and fixes that are missing in the recording
    std::int64_t bytes = 0;
};

/// May be given to from several threads; nobody waits for the disk, unless `wait`. A disk that is full or read-only costs what comes meanwhile, not the run.
class SessionRecorder {
public:
    /// An error where the folder is none that can be recorded to: it must be empty, or not there yet.
    static Result<std::unique_ptr<SessionRecorder>> start(const RecorderSettings& settings, SessionContent content);
    ~SessionRecorder();
    SessionRecorder(const SessionRecorder&) = delete;
    SessionRecorder& operator=(const SessionRecorder&) = delete;

    /// A frame that was looked at; its file is recorded, or its grey picture where it has none.
    void give(std::size_t camera, SourceFrame frame);
    void give(const RangeBatch& batch);
    void give(const OdometryBatch& batch);
    void give(const SightingBatch& batch);
    void give(std::shared_ptr<const FixBatch> batch);

    RecordingState state() const;
    /// Waits until all is written. The first error, with how much is missing in the recording.
    Result<void> finish();

private:
    struct Frame {
        std::size_t camera = 0;
        SourceFrame frame;
    };
    using Item = std::variant<Frame, RangeBatch, OdometryBatch, SightingBatch, std::shared_ptr<const FixBatch>>;

    SessionRecorder(const RecorderSettings& settings, SessionContent content);
    void push(Item item);
    bool has_room(bool frame) const;
    void work();
    void write(Item& item);
    void flush();
    void note(const Result<void>& result, long lost);

    RecorderSettings settings_;
    std::shared_ptr<const SessionContent> content_;
    SessionParts parts_;   // used by the thread
    double retry_at_ = 0;  // s of the clock: no part is made before

    mutable std::mutex mutex_;  // guards:
    std::condition_variable changed_;
    std::deque<Item> waiting_;
    std::size_t waiting_frames_ = 0;
    bool ending_ = false;
    RecordingState state_;
    double last_failure_ = 0;     // s of the clock
    std::optional<Error> error_;  // the first
    std::thread thread_;
};

}  // namespace roomfix
