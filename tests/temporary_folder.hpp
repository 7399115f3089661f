// A folder for the files of a test.
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

namespace roomfix {

/// Of its own for each test, empty at first and gone afterwards.
class TemporaryFolder : public ::testing::Test {
protected:
    void SetUp() override { std::filesystem::create_directories(folder); }
    void TearDown() override { std::filesystem::remove_all(folder); }

    std::filesystem::path folder = std::filesystem::temp_directory_path() /
                                   fmt::format("roomfix_{}_{}", ::testing::UnitTest::GetInstance()->current_test_info()->test_suite_name(), getpid());
};

}  // namespace roomfix
