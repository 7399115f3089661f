// Sinks that stand still, are slow or fail.
#include "roomfix/pipeline/sink_queue.hpp"

#include <gtest/gtest.h>

#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "roomfix/pipeline/fix_file.hpp"

namespace roomfix {
namespace {

std::shared_ptr<const FixBatch> batch_of(Nanoseconds time) { return std::make_shared<const FixBatch>(FixBatch{time, {}, {}}); }

/// What a sink got, and whether it may go on.
struct Door {
    std::mutex mutex;
    std::condition_variable changed;
    bool open = true;
    bool fails = false;
    bool inside = false;  // the sink has a batch in its hands
    std::vector<Nanoseconds> passed;

    void wait_until_inside() {
        std::unique_lock lock(mutex);
        changed.wait(lock, [this] { return inside; });
    }
    void unlock() {
        {
            const std::lock_guard lock(mutex);
            open = true;
        }
        changed.notify_all();
    }
};

class DoorSink final : public FixSink {
public:
    explicit DoorSink(Door& door) : door_(door) {}
    Result<void> give(const FixBatch& batch) override {
        std::unique_lock lock(door_.mutex);
        door_.inside = true;
        door_.changed.notify_all();
        door_.changed.wait(lock, [this] { return door_.open; });
        door_.inside = false;
        if (door_.fails) return Error{"batch " + std::to_string(batch.time) + " is lost"};
        door_.passed.push_back(batch.time);
        return {};
    }

private:
    Door& door_;
};

TEST(SinkQueue, WhereASinkStandsStillTheOldestAreDroppedAndNobodyWaits) {
    Door door;
    door.open = false;
    SinkQueue queue(std::make_unique<DoorSink>(door), 3, Overflow::drop_oldest);
    queue.give(batch_of(0));
    door.wait_until_inside();
    for (Nanoseconds time = 1; time <= 100; ++time) queue.give(batch_of(time));
    EXPECT_EQ(queue.dropped(), 97);
    door.unlock();
    const auto finished = queue.finish();
    ASSERT_FALSE(finished);
    EXPECT_EQ(finished.error().message, "a sink could not keep up: 97 moments are missing in it");
    EXPECT_EQ(door.passed, (std::vector<Nanoseconds>{0, 98, 99, 100}));
}

TEST(SinkQueue, OfWhatIsOnlyLookedAtTheNewestIsEnough) {
    Door door;
    door.open = false;
    SinkQueue queue(std::make_unique<DoorSink>(door), 1000, Overflow::newest_only);
    queue.give(batch_of(0));
    door.wait_until_inside();
    for (Nanoseconds time = 1; time <= 100; ++time) queue.give(batch_of(time));
    door.unlock();
    EXPECT_TRUE(queue.finish());
    EXPECT_EQ(door.passed, (std::vector<Nanoseconds>{0, 100}));
}

TEST(SinkQueue, OfARecordingNothingIsLost) {
    Door door;
    SinkQueue queue(std::make_unique<DoorSink>(door), 1, Overflow::wait);
    std::vector<Nanoseconds> all;
    for (Nanoseconds time = 0; time < 500; ++time) {
        queue.give(batch_of(time));
        all.push_back(time);
    }
    EXPECT_TRUE(queue.finish());
    EXPECT_EQ(door.passed, all);
    EXPECT_EQ(queue.dropped(), 0);
}

TEST(SinkQueue, AFailureIsToldAtTheEndAndWhatComesLaterIsTriedAgain) {
    Door door;
    door.fails = true;
    SinkQueue queue(std::make_unique<DoorSink>(door), 1, Overflow::wait);
    queue.give(batch_of(7));
    queue.give(batch_of(8));
    queue.give(batch_of(9));  // 7 has failed by now: only one waits
    {
        const std::lock_guard lock(door.mutex);
        door.fails = false;
    }
    queue.give(batch_of(10));
    const auto finished = queue.finish();
    ASSERT_FALSE(finished);
    EXPECT_EQ(finished.error().message, "batch 7 is lost");
    ASSERT_FALSE(door.passed.empty());
    EXPECT_EQ(door.passed.back(), 10);
}

TEST(FixFile, SaysSoWhereTheDiskIsFull) {
    auto file = FixFile::open("/dev/full");
    ASSERT_TRUE(file) << file.error().message;
    Fix fix;
    fix.robot = "r1";
    const auto given = (*file)->give({0, {fix}, {}});
    ASSERT_FALSE(given);
    EXPECT_EQ(given.error().message, "/dev/full: fixes could not be written and are lost: is the disk full?");
}

}  // namespace
}  // namespace roomfix
