// Threads that share out numbered jobs.
#pragma once

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace roomfix {

/// As many as this machine runs at once, at least 1.
inline int hardware_threads() { return static_cast<int>(std::max(1U, std::thread::hardware_concurrency())); }

class WorkerPool {
public:
    /// `threads` >= 1 that work, the caller's among them.
    explicit WorkerPool(int threads);
    ~WorkerPool();
    WorkerPool(const WorkerPool&) = delete;
    WorkerPool& operator=(const WorkerPool&) = delete;

    /// Runs job(0) .. job(count - 1), each once, in any order, and returns when all are done. From one thread at a time. Jobs must not
    /// throw.
    void run(int count, const std::function<void(int)>& job);

private:
    void work();
    void take_jobs();

    std::vector<std::thread> threads_;
    std::mutex mutex_;
    std::condition_variable begin_, end_;
    const std::function<void(int)>* job_ = nullptr;
    std::atomic<int> next_{0};
    int count_ = 0;
    int working_ = 0;  // threads that are still at this round
    long round_ = 0;
    bool stop_ = false;
};

}  // namespace roomfix
