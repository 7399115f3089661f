#include "roomfix/base/own_process.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <csignal>
#include <stdexcept>
#include <vector>

namespace roomfix {
namespace {

TEST(OwnProcess, GivesBackWhatItsWorkDoes) {
    std::string bytes(3'000'000, 'x');
    bytes[17] = '\0';
    int outside = 1;
    const auto result = in_own_process(
        [&] {
            outside = 2;
            return bytes;
        },
        10, 100);
    ASSERT_TRUE(result) << result.error().message;
    EXPECT_EQ(*result, bytes);
    EXPECT_EQ(outside, 1) << "it works on a copy";
    EXPECT_EQ(*in_own_process([] { return std::string(); }, 10, 100), "");
}

TEST(OwnProcess, SurvivesACrashAnExceptionAndAnEnd) {
    const std::vector<std::function<std::string()>> works = {
        [] {
            raise(SIGSEGV);
            return std::string("never");
        },
        [] {
            raise(SIGABRT);
            return std::string("never");
        },
        []() -> std::string { throw std::runtime_error("no"); },
        [] {
            _exit(0);
            return std::string("never");
        },
    };
    for (const auto& work : works) {
        const auto result = in_own_process(work, 10, 100);
        ASSERT_FALSE(result);
        EXPECT_EQ(result.error().message, "crashed");
    }
}

TEST(OwnProcess, EndsWhatNeverEnds) {
    const auto result = in_own_process(
        [] {
            volatile bool on = true;
            while (on) {
            }
            return std::string("never");
        },
        1, 100);
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().message, "took more than 1 s");
}

TEST(OwnProcess, EndsWhatTakesMoreAndMoreMemory) {
    const auto result = in_own_process(
        [] {
            std::vector<std::string> all;
            for (;;) all.emplace_back(1'000'000, 'x');
            return std::string("never");
        },
        10, 100);
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().message, "crashed");
}

}  // namespace
}  // namespace roomfix
