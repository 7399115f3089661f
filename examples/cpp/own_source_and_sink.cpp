// A source and a sink of one's own around roomfix's tracker: own_source_and_sink SESSION
// The source gives every second frame of the session's cameras; the sink prints lines of comma-separated values.
#include <fmt/format.h>

#include <atomic>
#include <memory>
#include <roomfix/pipeline/background_source.hpp>
#include <roomfix/pipeline/source_runner.hpp>
#include <roomfix/site/load_site.hpp>
#include <utility>
#include <vector>

namespace {

class EverySecond final : public roomfix::FrameSource {
public:
    explicit EverySecond(std::unique_ptr<roomfix::FrameSource> all) : all_(std::move(all)) {}
    roomfix::Result<bool> advance(roomfix::SourceFrame& frame) override {
        if (skip_) {
            auto skipped = all_->advance(frame);
            if (!skipped || !*skipped) return skipped;
        }
        skip_ = true;
        return all_->advance(frame);
    }
    roomfix::Result<void> decode(roomfix::SourceFrame& frame) override { return all_->decode(frame); }
    bool live() const override { return all_->live(); }
    std::int64_t count() const override { return (all_->count() + 1) / 2; }

private:
    std::unique_ptr<roomfix::FrameSource> all_;
    bool skip_ = false;
};

class Lines final : public roomfix::FixSink {
public:
    Lines() { fmt::print("time,robot,x,y,yaw\n"); }
    roomfix::Result<void> give(const roomfix::FixBatch& batch) override {
        for (const roomfix::Fix& fix : batch.given) {
            if (fix.status == roomfix::FixStatus::none) continue;
            fmt::print("{:.3f},{},{:.4f},{:.4f},{:.4f}\n", roomfix::to_seconds(fix.time), fix.robot, fix.pose.x, fix.pose.y, fix.pose.yaw);
        }
        return {};
    }
};

}  // namespace

int main(int count, char** arguments) {
    const auto give_up = [](const roomfix::Error& error) {
        fmt::print(stderr, "{}\n", error.message);
        return 1;
    };
    if (count != 2) return give_up({"usage: own_source_and_sink SESSION"});
    const auto site = roomfix::load_session(arguments[1]);
    if (!site) return give_up(site.error());
    auto tracker = roomfix::SiteTracker::create(*site);
    if (!tracker) return give_up(tracker.error());

    if (auto learned = roomfix::learn_backgrounds(**tracker, {}); !learned) return give_up(learned.error());
    std::vector<std::unique_ptr<roomfix::FrameSource>> sources;
    for (std::size_t i = 0; i < (*tracker)->cameras(); ++i) {
        const roomfix::SiteCamera& camera = (*tracker)->camera(i);
        auto frames = roomfix::open_source(roomfix::resolved_path(*site, camera.source));
        if (!frames) return give_up(frames.error());
        sources.push_back(std::make_unique<EverySecond>(std::move(*frames)));
    }
    roomfix::SourceRunner runner(**tracker);
    runner.add_sink(std::make_unique<Lines>(), roomfix::Overflow::wait);
    std::atomic<bool> stop{false};
    roomfix::RunSettings settings;
    settings.speed = 0;
    if (auto ran = runner.run(std::move(sources), settings, stop); !ran) return give_up(ran.error());
    if (auto written = runner.finish_sinks(); !written) return give_up(written.error());
}
