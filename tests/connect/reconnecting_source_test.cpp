#include "roomfix/connect/reconnecting_source.hpp"

#include <gtest/gtest.h>

#include <thread>
#include <vector>

namespace roomfix {
namespace {

/// Gives two frames and then fails.
class TwoFrames final : public FrameSource {
public:
    Result<bool> advance(SourceFrame& frame) override {
        if (given_ == 2) return Error{"unplugged"};
        frame.name = std::to_string(++given_);
        return true;
    }
    Result<void> decode(SourceFrame&) override { return {}; }
    bool live() const override { return true; }
    std::int64_t count() const override { return -1; }
    std::string note() const override { return "well"; }
    std::int64_t passed_over() const override { return 5; }

private:
    int given_ = 0;
};

std::unique_ptr<ReconnectingSource> camera_that_opens_at(std::vector<int> attempts, int& attempt) {
    const auto open = [attempts = std::move(attempts), &attempt](const std::atomic<bool>&) -> Result<std::unique_ptr<FrameSource>> {
        ++attempt;
        if (std::find(attempts.begin(), attempts.end(), attempt) == attempts.end()) return Error{"no camera"};
        return std::unique_ptr<FrameSource>(std::make_unique<TwoFrames>());
    };
    return std::make_unique<ReconnectingSource>(open, ReconnectSettings{std::chrono::milliseconds(1), std::chrono::milliseconds(4)});
}

TEST(ReconnectingSource, TellsWhatIsWrongAndGoesOnOnceTheCameraIsBack) {
    int attempt = 0;
    const auto source = camera_that_opens_at({3, 5}, attempt);
    std::vector<std::string> seen;
    for (int i = 0; i < 9; ++i) {
        SourceFrame frame;
        const auto more = source->next(frame);
        seen.push_back(more ? frame.name : more.error().message);
    }
    EXPECT_EQ(seen, (std::vector<std::string>{"no camera", "no camera", "1", "2", "unplugged", "no camera", "1", "2", "unplugged"}));
    EXPECT_EQ(attempt, 5);
    EXPECT_EQ(source->passed_over(), 10);  // of both connections
    EXPECT_EQ(source->note(), "");
}

TEST(ReconnectingSource, EndsItsWaitingWhenInterrupted) {
    int attempt = 0;
    const auto open = [&](const std::atomic<bool>&) -> Result<std::unique_ptr<FrameSource>> {
        ++attempt;
        return Error{"no camera"};
    };
    ReconnectingSource source(open, {std::chrono::hours(1), std::chrono::hours(1)});
    SourceFrame frame;
    EXPECT_FALSE(source.advance(frame));
    std::thread waiting([&] {
        const auto more = source.advance(frame);
        EXPECT_TRUE(more && !*more);
    });
    source.interrupt();
    waiting.join();
    EXPECT_EQ(attempt, 1);
}

}  // namespace
}  // namespace roomfix
