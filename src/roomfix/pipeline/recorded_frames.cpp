#include "roomfix/pipeline/recorded_frames.hpp"

#include <algorithm>

namespace roomfix {
namespace {

constexpr Nanoseconds round_span = 40'000'000;  // ns: what a frame tells about the next ones is that old at most

}  // namespace

RecordedFrames::RecordedFrames(std::vector<std::unique_ptr<FrameSource>>& sources, const std::atomic<bool>& stop,
                               std::function<void(std::size_t, const std::string&)> failed, std::function<void(std::size_t)> ended)
    : sources_(sources), stop_(stop), failed_(std::move(failed)), ended_(std::move(ended)), waiting_(sources.size()) {
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
        const auto more = sources_[camera]->next(frame);
        if (!more) {
            failed_(camera, more.error().message);
            continue;  // a damaged frame is skipped and counted
        }
        if (*more) waiting_[camera] = std::move(frame);
        if (!*more) ended_(camera);
        return;
    }
}

}  // namespace roomfix
