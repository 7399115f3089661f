#include "roomfix/pipeline/sink_queue.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace roomfix {

SinkQueue::SinkQueue(std::unique_ptr<FixSink> sink, std::size_t capacity, Overflow overflow)
    : sink_(std::move(sink)),
      capacity_(overflow == Overflow::newest_only ? 1 : std::max<std::size_t>(capacity, 1)),
      overflow_(overflow),
      thread_([this] { work(); }) {}

SinkQueue::~SinkQueue() { (void)finish(); }

void SinkQueue::give(std::shared_ptr<const FixBatch> batch) {
    {
        std::unique_lock lock(mutex_);
        if (overflow_ == Overflow::wait) {
            changed_.wait(lock, [this] { return waiting_.size() < capacity_; });
        } else if (waiting_.size() >= capacity_) {
            waiting_.pop_front();
            ++dropped_;
        }
        waiting_.push_back(std::move(batch));
    }
    changed_.notify_all();
}

void SinkQueue::work() {
    std::unique_lock lock(mutex_);
    while (true) {
        changed_.wait(lock, [this] { return ending_ || !waiting_.empty(); });
        if (waiting_.empty()) return;
        const std::shared_ptr<const FixBatch> batch = std::move(waiting_.front());
        waiting_.pop_front();
        lock.unlock();
        changed_.notify_all();
        const Result<void> given = sink_->give(*batch);
        lock.lock();
        keep_error(given);
    }
}

/// The mutex is held.
void SinkQueue::keep_error(const Result<void>& result) {
    trouble_ = result ? "" : result.error().message;
    if (!result && !error_) error_ = result.error();
}

Result<void> SinkQueue::finish() {
    {
        const std::lock_guard lock(mutex_);
        ending_ = true;
    }
    changed_.notify_all();
    if (thread_.joinable()) {
        thread_.join();
        const Result<void> finished = sink_->finish();
        const std::lock_guard lock(mutex_);
        keep_error(finished);
        if (overflow_ == Overflow::drop_oldest && dropped_ > 0) {
            keep_error(Error{fmt::format("{} could not keep up: {} moments are missing in it", sink_->name(), dropped_)});
        }
    }
    const std::lock_guard lock(mutex_);
    if (error_) return *error_;
    return {};
}

long SinkQueue::dropped() const {
    const std::lock_guard lock(mutex_);
    return dropped_;
}

SinkState SinkQueue::state() const {
    SinkState state = sink_->state();
    state.name = sink_->name();
    const std::lock_guard lock(mutex_);
    if (overflow_ == Overflow::drop_oldest) state.lost += dropped_;
    if (state.status == "ok" && !trouble_.empty()) {
        state.status = "failed";
        state.message = trouble_;
    }
    return state;
}

}  // namespace roomfix
