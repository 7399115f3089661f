#include "roomfix/connect/stream_clock.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>

namespace roomfix {
namespace {

constexpr Nanoseconds epoch = 1'800'000'000'000'000'000;

/// A camera with 25 pictures per second, whose media clock starts anywhere and drifts, behind a network that is late by chance.
struct SimulatedStream {
    double drift = 0;           // of the media clock against ours
    double least_delay = 0.04;  // s
    double mean_jitter = 0.01;
    double wall_ahead = 0;  // s, of the camera's wall clock
    double held_up = 0;     // share of the sender's reports that are off
    double held_up_by = 0;  // s, how much they are, on average
    std::mt19937 random{7};
    int number = 0;

    struct Picture {
        FrameArrival arrival;
        Nanoseconds taken = 0;
    };
    Picture next(bool tells_wall) {
        const double taken = 100 + 0.04 * number++;
        const double late = least_delay + std::exponential_distribution<double>(1 / mean_jitter)(random);
        Picture picture;
        picture.taken = epoch + from_seconds(taken);
        picture.arrival.steady = taken + late;
        picture.arrival.system = epoch + from_seconds(taken + late);
        picture.arrival.media = 5 + taken * (1 + drift);
        if (tells_wall) picture.arrival.wall = picture.taken + from_seconds(wall_ahead + report_off());
        return picture;
    }

private:
    /// What the last report was off by: there is one every 5 s.
    double report_off() {
        if (number % 125 == 1) off_ = std::bernoulli_distribution(held_up)(random) ? std::exponential_distribution<double>(1 / held_up_by)(random) : 0;
        return off_;
    }
    double off_ = 0;
};

double error(const StampedTime& stamp, Nanoseconds taken) { return to_seconds(stamp.time - taken); }

TEST(StreamClock, JitterAndDriftAreTakenOutOfTheTimesOfArrival) {
    for (const double drift : {0.0, 2e-4, -2e-4}) {
        SimulatedStream stream;
        stream.drift = drift;
        StreamClock clock(stream.least_delay);
        double largest = 0, raw = 0;
        for (int i = 0; i < 5000; ++i) {
            const auto picture = stream.next(false);
            const StampedTime stamp = clock.stamp(picture.arrival);
            if (i < 500) continue;
            largest = std::max(largest, std::abs(error(stamp, picture.taken)));
            raw = std::max(raw, to_seconds(picture.arrival.system - picture.taken) - stream.least_delay);
            EXPECT_LE(std::abs(error(stamp, picture.taken)), 3 * stamp.error.sigma);
        }
        EXPECT_LT(largest, 0.004) << drift;
        EXPECT_GT(raw, 0.05);
    }
}

TEST(StreamClock, WhereTheDelayIsNotKnownTheStatedSigmaSaysSo) {
    SimulatedStream stream;
    StreamClock clock;
    StampedTime stamp;
    Nanoseconds taken = 0;
    for (int i = 0; i < 200; ++i) {
        const auto picture = stream.next(false);
        taken = picture.taken;
        stamp = clock.stamp(picture.arrival);
    }
    EXPECT_NEAR(error(stamp, taken), stream.least_delay, 0.005);
    EXPECT_GE(stamp.error.sigma, 0.05);
    EXPECT_NE(clock.told().find("state it as 'delay'"), std::string::npos) << clock.told();
}

TEST(StreamClock, TheSendersWallClockIsTakenAndTeachesTheDelayForTheNextConnection) {
    SimulatedStream stream;
    StreamClock clock;
    for (int i = 0; i < 500; ++i) {
        const auto picture = stream.next(i > 20);
        const StampedTime stamp = clock.stamp(picture.arrival);
        if (i > 25) {
            EXPECT_EQ(stamp.time, picture.taken);
        }
    }
    EXPECT_NE(clock.told().find("the camera's own"), std::string::npos) << clock.told();
    clock.restart();
    StampedTime stamp;
    Nanoseconds taken = 0;
    for (int i = 0; i < 100; ++i) {
        const auto picture = stream.next(false);
        stamp = clock.stamp(picture.arrival);
        taken = picture.taken;
    }
    EXPECT_NEAR(error(stamp, taken), 0, 0.005);
    EXPECT_LT(stamp.error.sigma, 0.01);
}

TEST(StreamClock, TheFirstPicturesOfAConnectionAreAsWrongAsTheySay) {
    SimulatedStream stream;
    StreamClock clock;
    double squares = 0;
    constexpr int connections = 200, pictures = 4;
    std::set<int> ways;
    for (int connection = 0; connection < connections; ++connection) {
        for (int i = 0; i < 100; ++i) {
            const auto picture = stream.next(i >= 20);
            const StampedTime stamp = clock.stamp(picture.arrival);
            if (connection == 0) continue;  // what it takes to come is not known yet
            if (i == 0) ways.insert(stamp.error.way);
            if (i == 99) EXPECT_EQ(stamp.error.way, 0);
            if (i < pictures) squares += std::pow(error(stamp, picture.taken) / stamp.error.sigma, 2);
        }
        clock.restart();
    }
    EXPECT_EQ(ways.size(), connections - 1U);
    EXPECT_FALSE(ways.contains(0));
    const double mean = squares / (pictures * (connections - 1));
    EXPECT_GT(mean, 0.01);  // it could be as late as pictures of a busy machine, and is not
    EXPECT_LT(mean, 1.5);
}

TEST(StreamClock, AWallClockThatIsWrongIsNotBelievedAndNamed) {
    for (const double ahead : {0.3, -3600.0}) {
        SimulatedStream stream;
        stream.wall_ahead = ahead;
        StreamClock clock(stream.least_delay);
        for (int i = 0; i < 300; ++i) {
            const auto picture = stream.next(true);
            const StampedTime stamp = clock.stamp(picture.arrival);
            if (i > 100) {
                EXPECT_NEAR(error(stamp, picture.taken), 0, 0.01);
            }
        }
        EXPECT_NE(clock.told().find(ahead > 0 ? "ahead of ours" : "behind ours"), std::string::npos) << clock.told();
    }
}

TEST(StreamClock, OneReportThatIsOffMovesNoTimes) {
    double squares = 0, far = 0, number = 0;
    for (const double drift : {-1e-4, 0.0, 1e-4}) {
        SimulatedStream stream;
        stream.random.seed(std::random_device{}());
        stream.drift = drift;
        stream.held_up = 0.1;
        stream.held_up_by = 0.02;
        StreamClock clock;
        for (int i = 0; i < 25 * 3600; ++i) {
            const auto picture = stream.next(true);
            const StampedTime stamp = clock.stamp(picture.arrival);
            const double off = error(stamp, picture.taken);
            squares += std::pow(off / stamp.error.sigma, 2);
            far += std::abs(off) > 0.005 ? 1 : 0;
            ++number;
        }
    }
    EXPECT_LT(squares / number, 1);
    EXPECT_LT(far / number, 0.03);  // 0.08 of the times of single reports are off by more
}

TEST(StreamClock, AWallClockThatIsSetAnewIsFollowedAndSaidMeanwhile) {
    SimulatedStream stream;
    StreamClock clock;
    double squares = 0;
    int number = 0;
    for (int i = 0; i < 25 * 120; ++i) {
        if (i == 25 * 60) stream.wall_ahead = -0.1;
        const auto picture = stream.next(true);
        const StampedTime stamp = clock.stamp(picture.arrival);
        const double off = error(stamp, picture.taken) - stream.wall_ahead;
        if (i > 25 * 61) {
            squares += std::pow(off / stamp.error.sigma, 2);
            ++number;
        }
        if (i > 25 * 95) EXPECT_NEAR(off, 0, 0.001);
    }
    EXPECT_LT(squares / number, 2);
}

TEST(StreamClock, TimesRiseWhateverTheStreamDoes) {
    SimulatedStream stream;
    StreamClock clock;
    Nanoseconds last = 0;
    for (int i = 0; i < 1000; ++i) {
        auto picture = stream.next(i % 100 > 30);
        if (i == 500) clock.restart();
        if (i > 700) picture.arrival.media = *picture.arrival.media - 90000;  // the camera was restarted behind a relay
        const StampedTime stamp = clock.stamp(picture.arrival);
        if (i != 701) {
            EXPECT_GT(stamp.time, last);
        }
        EXPECT_NEAR(error(stamp, picture.taken), 0, 0.2);
        EXPECT_GT(stamp.error.sigma, 0);
        last = stamp.time;
    }
}

TEST(StreamClock, PicturesThatAreSentInAnotherOrderKeepTheirTimes) {
    SimulatedStream stream;
    stream.mean_jitter = 0.001;
    StreamClock clock(stream.least_delay);
    for (int i = 0; i < 200; ++i) {
        // As with pictures that are coded from one before and one behind them: each second one is sent after the one that follows it.
        auto earlier = stream.next(false);
        auto later = stream.next(false);
        std::swap(earlier.arrival.media, later.arrival.media);
        std::swap(earlier.taken, later.taken);
        const StampedTime first = clock.stamp(earlier.arrival);
        const StampedTime second = clock.stamp(later.arrival);
        if (i > 20) {
            EXPECT_NEAR(to_seconds(first.time - second.time), 0.04, 0.001);
        }
    }
}

TEST(StreamClock, OurClockMayBeSetAnew) {
    SimulatedStream stream;
    StreamClock clock(stream.least_delay);
    for (int i = 0; i < 400; ++i) {
        auto picture = stream.next(false);
        const Nanoseconds set_back = i > 200 ? from_seconds(3600) : 0;
        picture.arrival.system -= set_back;
        const StampedTime stamp = clock.stamp(picture.arrival);
        if (i > 100) {
            EXPECT_NEAR(error(stamp, picture.taken - set_back), 0, 0.01) << i;
        }
    }
}

}  // namespace
}  // namespace roomfix
