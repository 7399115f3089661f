// A live camera that may vanish and come back.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <string>

#include "roomfix/connect/frame_source.hpp"

namespace roomfix {

/// Opens a camera, or says why it is not there. It gives up soon once `stop` is set.
using SourceOpener = std::function<Result<std::unique_ptr<FrameSource>>(const std::atomic<bool>& stop)>;

struct ReconnectSettings {
    std::chrono::milliseconds first_wait{200};  // before the second attempt; it doubles with each
    std::chrono::milliseconds longest_wait{2000};
};

/// Opens its camera when it is asked for the first frame, and again, with growing waits, when it fails or ends. Meanwhile each `advance` waits for the next
/// attempt and is an error that says what is wrong.
class ReconnectingSource final : public FrameSource {
public:
    explicit ReconnectingSource(SourceOpener open, ReconnectSettings settings = {});
    ~ReconnectingSource() override;

    Result<bool> advance(SourceFrame& frame) override;
    Result<void> decode(SourceFrame& frame) override;
    bool live() const override { return true; }
    std::int64_t count() const override { return -1; }
    std::string note() const override;
    std::int64_t passed_over() const override;
    void interrupt() override;
    void keep_files() override;

private:
    Result<void> connect();
    void wait();

    SourceOpener open_;
    ReconnectSettings settings_;
    std::chrono::milliseconds wait_{0};  // before the next attempt
    bool keeps_files_ = false;
    std::int64_t passed_over_ = 0;  // by connections that ended
    std::atomic<bool> stop_{false};
    mutable std::mutex mutex_;  // for `source_` and waiting
    std::condition_variable stopped_;
    std::unique_ptr<FrameSource> source_;
};

}  // namespace roomfix
