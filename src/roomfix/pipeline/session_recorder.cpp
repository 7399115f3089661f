#include "roomfix/pipeline/session_recorder.hpp"

#include <fmt/format.h>

#include <chrono>
#include <utility>

#include "roomfix/base/steady_now.hpp"

namespace roomfix {
namespace {

constexpr std::size_t most_frames = 32;    // that wait
constexpr std::size_t most_items = 20000;  // that wait, of any kind
constexpr double flush_interval = 0.25;    // s
constexpr double retry_interval = 1;       // s between attempts to make a session
constexpr double calm = 2;                 // s without a failure: recording goes on again

/// How many lines or frames an item is.
struct SizeOf {
    template <class Frame>
    long operator()(const Frame&) const {
        return 1;
    }
    long operator()(const RangeBatch& batch) const { return static_cast<long>(batch.ranges.size() + batch.differences.size()); }
    long operator()(const OdometryBatch& batch) const { return static_cast<long>(batch.poses.size()); }
    long operator()(const SightingBatch& batch) const { return static_cast<long>(batch.sightings.size()); }
    long operator()(const std::shared_ptr<const FixBatch>& batch) const { return static_cast<long>(batch->given.size()); }
};

/// Adds the lines of an item to a session.
struct AddLines {
    SessionWriter& session;

    void operator()(const RangeBatch& batch) const {
        for (const RangeObservation& range : batch.ranges) session.add(range);
        for (const RangeDifferenceObservation& difference : batch.differences) session.add(difference);
    }
    void operator()(const OdometryBatch& batch) const {
        for (const OdometryObservation& pose : batch.poses) session.add(pose);
    }
    void operator()(const SightingBatch& batch) const {
        for (const SightingObservation& sighting : batch.sightings) session.add(sighting);
    }
    void operator()(const std::shared_ptr<const FixBatch>& batch) const {
        for (const Fix& fix : batch->given) session.add(fix);
    }
};

Result<void> add_frame(SessionWriter& session, const std::string& camera, const SourceFrame& frame) {
    const auto file = frame.file ? frame.file() : !frame.encoded.empty() ? Result<PictureFile>(PictureFile{frame.encoded, "jpg"}) : grey_file(frame.image);
    if (!file) return file.error();
    return session.add_frame(camera, frame.time, frame.time_error, *file);
}

}  // namespace

Result<std::unique_ptr<SessionRecorder>> SessionRecorder::start(const RecorderSettings& settings, SessionContent content) {
    namespace fs = std::filesystem;
    std::error_code failure;
    const fs::file_status status = fs::status(settings.folder, failure);
    if (fs::exists(status) && !fs::is_directory(status)) {
        return Error{fmt::format("{}: is a file, not a folder to record to: choose another name", settings.folder.string())};
    }
    if (fs::is_directory(status) && !fs::is_empty(settings.folder, failure) && !failure) {
        return Error{
            fmt::format("{}: is not empty, and nothing in it is overwritten: choose a new folder to record to, or empty this one", settings.folder.string())};
    }
    return std::unique_ptr<SessionRecorder>(new SessionRecorder(settings, std::move(content)));
}

SessionRecorder::SessionRecorder(const RecorderSettings& settings, SessionContent content)
    : settings_(settings),
      content_(std::make_shared<const SessionContent>(std::move(content))),
      parts_(settings.folder, content_, settings.limits),
      thread_([this] { work(); }) {}

SessionRecorder::~SessionRecorder() { (void)finish(); }

void SessionRecorder::give(std::size_t camera, SourceFrame frame) { push(Frame{camera, std::move(frame)}); }
void SessionRecorder::give(const RangeBatch& batch) { push(RangeBatch{batch.ranges, batch.differences, {}}); }
void SessionRecorder::give(const OdometryBatch& batch) { push(OdometryBatch{batch.poses, {}}); }
void SessionRecorder::give(const SightingBatch& batch) { push(SightingBatch{batch.sightings, {}}); }
void SessionRecorder::give(std::shared_ptr<const FixBatch> batch) { push(std::move(batch)); }

/// The mutex is held.
bool SessionRecorder::has_room(bool frame) const { return waiting_.size() < most_items && (!frame || waiting_frames_ < most_frames); }

void SessionRecorder::push(Item item) {
    const long size = std::visit(SizeOf{}, item);
    if (size == 0) return;
    const bool frame = std::holds_alternative<Frame>(item);
    {
        std::unique_lock lock(mutex_);
        if (settings_.wait) changed_.wait(lock, [&] { return has_room(frame); });
        if (!has_room(frame)) {
            lock.unlock();
            note(Error{"the disk is too slow for the recording: choose a faster one, or fewer or smaller frames"}, size);
            return;
        }
        waiting_.push_back(std::move(item));
        waiting_frames_ += frame;
    }
    changed_.notify_all();
}

void SessionRecorder::work() {
    const auto until = [](double wall) { return std::chrono::duration<double>(std::max(wall - steady_now(), 0.0)); };
    double flush_at = steady_now();  // at once: a session is there before anything comes
    std::unique_lock lock(mutex_);
    while (true) {
        changed_.wait_for(lock, until(flush_at), [this] { return ending_ || !waiting_.empty(); });
        if (waiting_.empty() && ending_) break;
        std::optional<Item> item;
        if (!waiting_.empty()) {
            item = std::move(waiting_.front());
            waiting_.pop_front();
            waiting_frames_ -= std::holds_alternative<Frame>(*item);
        }
        lock.unlock();
        changed_.notify_all();
        if (item) write(*item);
        if (steady_now() >= flush_at) {
            flush();
            flush_at = steady_now() + flush_interval;
        }
        lock.lock();
    }
    lock.unlock();
    flush();
}

void SessionRecorder::write(Item& item) {
    const long size = std::visit(SizeOf{}, item);
    const double now = steady_now();
    if (now < retry_at_) return note({}, size);
    const auto session = parts_.current(now);
    if (!session) {
        retry_at_ = now + retry_interval;
        return note(session.error(), size);
    }
    if (const Frame* frame = std::get_if<Frame>(&item)) {
        const auto added = add_frame(**session, content_->cameras[frame->camera], frame->frame);
        note(added, added ? 0 : 1);
        const std::lock_guard lock(mutex_);
        state_.frames += added ? 1 : 0;
        return;
    }
    std::visit(
        [&](const auto& lines) {
            if constexpr (!std::is_same_v<std::decay_t<decltype(lines)>, Frame>) AddLines{**session}(lines);
        },
        item);
}

void SessionRecorder::flush() {
    const double now = steady_now();
    if (now < retry_at_) return;
    const auto session = parts_.current(now);
    if (!session) retry_at_ = now + retry_interval;
    note(session ? parts_.flush() : Result<void>(session.error()), 0);
    const std::lock_guard lock(mutex_);
    state_.bytes = parts_.bytes();
}

/// What became of something that was to be written. Failures are told when they begin and when they are over.
void SessionRecorder::note(const Result<void>& result, long lost) {
    std::string told;
    {
        const std::lock_guard lock(mutex_);
        const double now = steady_now();
        state_.lost += lost;
        if (!result) {
            if (!error_) error_ = result.error();
            if (state_.ok) told = "not recorded: " + result.error().message;
            state_.ok = false;
            state_.message = result.error().message;
            last_failure_ = now;
        } else if (lost == 0 && !state_.ok && now - last_failure_ > calm) {
            state_ = {true, "", state_.frames, state_.lost, state_.bytes};
            told = fmt::format("recording goes on: {} frames, readings and fixes are missing", state_.lost);
        }
    }
    if (!told.empty() && settings_.on_trouble) settings_.on_trouble(told);
}

RecordingState SessionRecorder::state() const {
    const std::lock_guard lock(mutex_);
    return state_;
}

Result<void> SessionRecorder::finish() {
    {
        const std::lock_guard lock(mutex_);
        ending_ = true;
    }
    changed_.notify_all();
    if (thread_.joinable()) {
        thread_.join();
        note(parts_.finish(), 0);
        const std::lock_guard lock(mutex_);
        state_.lost += parts_.lost_lines();
        state_.bytes = parts_.bytes();
        if (error_) error_->message += fmt::format("; {} frames, readings and fixes are missing in the recording", state_.lost);
    }
    if (error_) return *error_;
    return {};
}

}  // namespace roomfix
