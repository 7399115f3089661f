#include "roomfix/pipeline/frame_queue.hpp"

#include <chrono>
#include <thread>

namespace roomfix {

void FrameQueue::push(SourceFrame frame) {
    {
        const std::lock_guard lock(mutex_);
        ++count_.came;
        if (frames_.size() == most_) {
            frames_.pop_front();
            ++count_.dropped;
        }
        frames_.push_back(std::move(frame));
    }
    changed_.notify_one();
}

bool FrameQueue::pop(SourceFrame& frame) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return closed_ || !frames_.empty(); });
    if (frames_.empty()) return false;
    frame = std::move(frames_.front());
    frames_.pop_front();
    return true;
}

void FrameQueue::close() {
    {
        const std::lock_guard lock(mutex_);
        closed_ = true;
    }
    changed_.notify_all();
}

FrameCount FrameQueue::count() const {
    const std::lock_guard lock(mutex_);
    return count_;
}

void follow_live(FrameSource& source, const std::atomic<bool>& stop, const std::function<void(const SourceFrame&, const FrameCount&)>& use,
                 const std::function<void(const std::string&)>& failed) {
    FrameQueue queue;
    std::thread reader([&] {
        SourceFrame frame;
        while (!stop) {
            const auto more = source.next(frame);
            if (!more) {
                failed(more.error().message);
                std::this_thread::sleep_for(std::chrono::milliseconds(200));
                continue;
            }
            if (!*more) break;
            queue.push(std::move(frame));
            frame = {};
        }
        queue.close();
    });
    SourceFrame frame;
    while (!stop && queue.pop(frame)) use(frame, queue.count());
    reader.join();
}

}  // namespace roomfix
