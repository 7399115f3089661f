#include "roomfix/pipeline/recorded_frames.hpp"

#include <algorithm>

#include "roomfix/base/steady_now.hpp"

namespace roomfix {

RecordedFrames::RecordedFrames(std::vector<std::unique_ptr<FrameSource>>& sources, const std::atomic<bool>& stop, Listener listener)
    : sources_(sources), stop_(stop), listener_(std::move(listener)), waiting_(sources.size()) {
    for (std::size_t i = 0; i < sources.size(); ++i) {
        if (sources[i]->live()) continue;
        total_ += static_cast<double>(std::max<std::int64_t>(sources[i]->count(), 1));
        advance(i);
    }
}

std::vector<std::size_t> RecordedFrames::next_round() const {
    std::vector<std::size_t> round;
    for (std::size_t i = 0; i < waiting_.size(); ++i) {
        if (waiting_[i]) round.push_back(i);
    }
    std::stable_sort(round.begin(), round.end(), [&](std::size_t a, std::size_t b) { return waiting_[a]->time < waiting_[b]->time; });
    while (!round.empty() && waiting_[round.back()]->time > waiting_[round.front()]->time + round_span) round.pop_back();
    return round;
}

void RecordedFrames::advance(std::size_t camera) {
    waiting_[camera].reset();
    while (!stop_) {
        SourceFrame frame;
        const auto more = sources_[camera]->advance(frame);
        if (more && !*more) {
            listener_.ended(camera);
            return;
        }
        if (more && listener_.too_late && listener_.too_late(camera, frame.time)) continue;
        const double before = steady_now();
        const auto decoded = more ? sources_[camera]->decode(frame) : Result<void>(more.error());
        if (!decoded) {
            listener_.failed(camera, decoded.error().message);
            continue;  // a damaged frame is skipped and counted
        }
        if (listener_.decoded) listener_.decoded(steady_now() - before);
        waiting_[camera] = std::move(frame);
        return;
    }
}

}  // namespace roomfix
