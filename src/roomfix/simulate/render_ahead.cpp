#include "roomfix/simulate/render_ahead.hpp"

#include <sys/resource.h>

#include <cmath>

#include "roomfix/base/worker_pool.hpp"

namespace roomfix {

RenderAhead::RenderAhead(std::size_t cameras, double frame_rate, std::function<double()> now, Render render)
    : frame_rate_(frame_rate), now_(std::move(now)), render_(std::move(render)), cameras_(cameras) {
    for (int i = 0; i < hardware_threads(); ++i) threads_.emplace_back([this] { work(); });
}

RenderAhead::~RenderAhead() {
    {
        const std::lock_guard lock(mutex_);
        stop_ = true;
    }
    changed_.notify_all();
    for (std::thread& thread : threads_) thread.join();
}

RenderAhead::Moment RenderAhead::take() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return !planned_.empty() && planned_.front().open == 0; });
    Moment moment = std::move(planned_.front().moment);
    planned_.pop_front();
    changed_.notify_all();
    return moment;
}

void RenderAhead::plan() {
    Planned& next = planned_.emplace_back();
    next.since = now_();
    tick_ = std::max(tick_ + 1, static_cast<std::int64_t>(std::ceil((next.since + lasts_) * frame_rate_)));
    next.moment.time = static_cast<double>(tick_) / frame_rate_;
    next.moment.frames.resize(cameras_.size());
    next.number = moments_++;
    next.open = cameras_.size();
}

void RenderAhead::work() {
    constexpr std::size_t most_ahead = 3;
    constexpr int give_way = 10;  // of the niceness, which on Linux each thread has of its own
    (void)setpriority(PRIO_PROCESS, 0, give_way);
    std::unique_lock lock(mutex_);
    while (true) {
        const auto to_do = [this] { return !planned_.empty() && planned_.back().begun < cameras_.size(); };
        changed_.wait(lock, [&] { return stop_ || to_do() || planned_.size() < most_ahead; });
        if (stop_) return;
        if (!to_do()) plan();
        Planned& planned = planned_.back();  // stays there: it is not taken before its last picture is done
        const std::size_t number = planned.begun++;
        lock.unlock();
        Camera& camera = cameras_[number];
        {
            const std::lock_guard one_at_a_time(camera.mutex);
            render_(number, planned.moment.time, planned.number, camera.frame);
            planned.moment.frames[number] = camera.frame;
        }
        lock.lock();
        if (--planned.open == 0) {
            lasts_ += 0.2 * (now_() - planned.since - lasts_);
            changed_.notify_all();
        }
    }
}

}  // namespace roomfix
