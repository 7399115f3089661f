#include "roomfix/simulate/render_ahead.hpp"

#include <sys/resource.h>

#include <cmath>

#include "roomfix/base/worker_pool.hpp"

namespace roomfix {

RenderAhead::RenderAhead(std::size_t cameras, double frame_rate, std::function<double()> now, Render render)
    : cameras_(cameras), frame_rate_(frame_rate), now_(std::move(now)), render_(std::move(render)), thread_([this] { work(); }) {}

RenderAhead::~RenderAhead() {
    {
        const std::lock_guard lock(mutex_);
        stop_ = true;
    }
    changed_.notify_all();
    thread_.join();
}

RenderAhead::Moment RenderAhead::take() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return !ready_.empty(); });
    Moment moment = std::move(ready_.front());
    ready_.pop();
    changed_.notify_all();
    return moment;
}

void RenderAhead::work() {
    constexpr std::size_t most_ahead = 2;
    constexpr int give_way = 10;  // of the niceness, which on Linux each thread has of its own and hands on to those that it starts
    (void)setpriority(PRIO_PROCESS, 0, give_way);
    WorkerPool pool(hardware_threads());
    Moment moment;
    moment.frames.resize(cameras_);
    double lasts = 0;  // s, what rendering a moment takes
    std::int64_t tick = -1;
    for (std::uint64_t number = 0;; ++number) {
        const double start = now_();
        tick = std::max(tick + 1, static_cast<std::int64_t>(std::ceil((start + lasts) * frame_rate_)));
        moment.time = static_cast<double>(tick) / frame_rate_;
        pool.run(static_cast<int>(cameras_), [&](int camera) {
            const auto c = static_cast<std::size_t>(camera);
            render_(c, moment.time, number, moment.frames[c]);
        });
        lasts += 0.2 * (now_() - start - lasts);
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [this] { return stop_ || ready_.size() < most_ahead; });
        if (stop_) return;
        ready_.push(moment);
        changed_.notify_all();
    }
}

}  // namespace roomfix
