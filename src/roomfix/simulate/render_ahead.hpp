// Pictures that are ready when their time comes, as a real camera's are.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <queue>
#include <thread>
#include <vector>

#include "roomfix/imaging/luma.hpp"

namespace roomfix {

/// Renders the pictures of all cameras for moments that are still to come, at most two ahead, in threads that give way to all others. Where
/// that is slower than the frame rate, moments are left out.
class RenderAhead {
public:
    struct Moment {
        double time = 0;                // s
        std::vector<LumaImage> frames;  // of each camera
    };
    /// `now` tells the time (s, at least 0). `render` renders one camera's picture of a time, the number-th that is rendered; it may be called
    /// for several cameras at once. A camera's frame still holds its last picture.
    using Render = std::function<void(std::size_t camera, double time, std::uint64_t number, LumaImage& frame)>;
    RenderAhead(std::size_t cameras, double frame_rate, std::function<double()> now, Render render);
    ~RenderAhead();
    RenderAhead(const RenderAhead&) = delete;
    RenderAhead& operator=(const RenderAhead&) = delete;

    /// The next moment; waits until it is rendered, but not for its time to come.
    Moment take();

private:
    void work();

    std::size_t cameras_;
    double frame_rate_;
    std::function<double()> now_;
    Render render_;
    std::mutex mutex_;
    std::condition_variable changed_;
    std::queue<Moment> ready_;
    bool stop_ = false;
    std::thread thread_;
};

}  // namespace roomfix
