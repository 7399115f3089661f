// Pictures that are ready when their time comes, as a real camera's are.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

#include "roomfix/imaging/luma.hpp"

namespace roomfix {

/// Renders the pictures of all cameras for moments that are still to come, in threads that give way to all others. Where that is slower than
/// the frame rate, moments are left out.
class RenderAhead {
public:
    struct Moment {
        double time = 0;                // s
        std::vector<LumaImage> frames;  // of each camera
    };
    /// `now` tells the time (s, at least 0). `render` renders one camera's picture of a time, the number-th moment that is rendered; it is
    /// called for one picture of a camera at a time, but for several cameras at once. A camera's frame still holds its last picture.
    using Render = std::function<void(std::size_t camera, double time, std::uint64_t number, LumaImage& frame)>;
    RenderAhead(std::size_t cameras, double frame_rate, std::function<double()> now, Render render);
    ~RenderAhead();
    RenderAhead(const RenderAhead&) = delete;
    RenderAhead& operator=(const RenderAhead&) = delete;

    /// The next moment; waits until it is rendered, but not for its time to come.
    Moment take();

private:
    struct Planned {
        Moment moment;
        std::uint64_t number = 0;
        double since = 0;       // s, when it was planned
        std::size_t begun = 0;  // cameras
        std::size_t open = 0;   // cameras whose pictures are not done
    };
    struct Camera {
        std::mutex mutex;
        LumaImage frame;
    };
    void work();
    void plan();

    double frame_rate_;
    std::function<double()> now_;
    Render render_;
    std::vector<Camera> cameras_;
    std::mutex mutex_;
    std::condition_variable changed_;
    std::deque<Planned> planned_;  // the oldest in front; what is in work stays where it is
    std::uint64_t moments_ = 0;
    std::int64_t tick_ = -1;  // of the newest moment, frames of the frame rate
    double lasts_ = 0;        // s, from a moment's plan to its last picture
    bool stop_ = false;
    std::vector<std::thread> threads_;
};

}  // namespace roomfix
