#include "roomfix/connect/time_errors.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "roomfix/connect/frame_source.hpp"
#include "temporary_folder.hpp"

namespace roomfix {
namespace {

namespace fs = std::filesystem;

class TimeErrors : public TemporaryFolder {
protected:
    void write(const std::string& text) const { std::ofstream(folder / time_errors_name) << text; }
};

TEST_F(TimeErrors, AFrameHasTheLastOneThatWasNotedUntilThen) {
    write(std::string(time_error_columns) + time_error_line({1000, {0.05, 1}}) + time_error_line({3000, {0.003, 0}}));
    for (const char* name : {"500", "1000", "2999", "3000", "9000"}) {
        LumaImage image(8, 8);
        const auto picture = grey_file(image);
        ASSERT_TRUE(picture) << picture.error().message;
        std::ofstream(folder / fmt::format("{}.png", name), std::ios::binary)
            .write(reinterpret_cast<const char*>(picture->bytes.data()), static_cast<std::streamsize>(picture->bytes.size()));
    }
    const auto source = open_source(folder.string());
    ASSERT_TRUE(source) << source.error().message;
    for (const TimeError expected : {TimeError{0, 0}, TimeError{0.05, 1}, TimeError{0.05, 1}, TimeError{0.003, 0}, TimeError{0.003, 0}}) {
        SourceFrame frame;
        ASSERT_TRUE(*(*source)->advance(frame));
        EXPECT_EQ(frame.time_error.sigma, expected.sigma) << frame.name;
        EXPECT_EQ(frame.time_error.way, expected.way) << frame.name;
    }
}

TEST_F(TimeErrors, AFileThatCannotBeUnderstoodIsRefusedWithItsLine) {
    for (const char* bad : {"7,0.05", "7,-0.05,1", "7,nan,1", "seven,0.05,1", "7,0.05,1.5", "7,1e9,1", "7,0.05,-1", "7,0.05,1,2", "nanoseconds,sigma,way"}) {
        write(fmt::format("{}1,0.05,1\n\n{}\n", time_error_columns, bad));
        const auto read = read_time_errors(folder / time_errors_name);
        ASSERT_FALSE(read) << bad;
        EXPECT_NE(read.error().message.find(fmt::format("time-errors.csv, line 4: '{}' is not", bad)), std::string::npos) << read.error().message;
    }
    write("7,0.05,1\n6,0.05,1\n");
    const auto read = read_time_errors(folder / time_errors_name);
    ASSERT_FALSE(read);
    EXPECT_NE(read.error().message.find("line 2: earlier than the line before"), std::string::npos) << read.error().message;
    std::ofstream(folder / "1.png") << "picture";
    const auto source = open_source(folder.string());
    ASSERT_FALSE(source);
    EXPECT_NE(source.error().message.find("line 2"), std::string::npos) << source.error().message;
}

}  // namespace
}  // namespace roomfix
