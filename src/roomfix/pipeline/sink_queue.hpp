// A sink's queue and its thread: what gives the fixes never waits for a slow sink, unless nothing may be lost.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "roomfix/pipeline/fix_sink.hpp"

namespace roomfix {

class SinkQueue {
public:
    /// `capacity`: batches that may wait, at least 1; of `newest_only` it is 1.
    SinkQueue(std::unique_ptr<FixSink> sink, std::size_t capacity, Overflow overflow);
    ~SinkQueue();
    SinkQueue(const SinkQueue&) = delete;
    SinkQueue& operator=(const SinkQueue&) = delete;

    /// From any thread.
    void give(std::shared_ptr<const FixBatch> batch);
    /// Waits until all that was given has been passed on, and ends the thread. The first error of the sink, or how much was lost.
    Result<void> finish();
    /// Batches that were thrown away.
    long dropped() const;
    /// Of the sink, and of what waits for it.
    SinkState state() const;

private:
    void work();
    void keep_error(const Result<void>& result);

    std::unique_ptr<FixSink> sink_;
    std::size_t capacity_;
    Overflow overflow_;
    mutable std::mutex mutex_;
    std::condition_variable changed_;
    std::deque<std::shared_ptr<const FixBatch>> waiting_;
    std::optional<Error> error_;  // the first
    std::string trouble_;         // with the last batch; empty: none
    long dropped_ = 0;
    bool ending_ = false;
    std::thread thread_;
};

}  // namespace roomfix
