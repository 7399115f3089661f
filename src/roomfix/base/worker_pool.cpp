#include "roomfix/base/worker_pool.hpp"

namespace roomfix {

WorkerPool::WorkerPool(int threads) {
    for (int i = 1; i < threads; ++i) threads_.emplace_back([this] { work(); });
}

WorkerPool::~WorkerPool() {
    {
        const std::lock_guard lock(mutex_);
        stop_ = true;
    }
    begin_.notify_all();
    for (std::thread& thread : threads_) thread.join();
}

void WorkerPool::take_jobs() {
    for (int i = next_++; i < count_; i = next_++) (*job_)(i);
}

void WorkerPool::run(int count, const std::function<void(int)>& job) {
    {
        const std::lock_guard lock(mutex_);
        job_ = &job;
        count_ = count;
        next_ = 0;
        working_ = static_cast<int>(threads_.size());
        ++round_;
    }
    begin_.notify_all();
    take_jobs();
    std::unique_lock lock(mutex_);
    end_.wait(lock, [this] { return working_ == 0; });
}

void WorkerPool::work() {
    long done = 0;
    while (true) {
        {
            std::unique_lock lock(mutex_);
            begin_.wait(lock, [&] { return stop_ || round_ != done; });
            if (stop_) return;
            done = round_;
        }
        take_jobs();
        const std::lock_guard lock(mutex_);
        if (--working_ == 0) end_.notify_one();
    }
}

}  // namespace roomfix
