#include "roomfix/pipeline/line_problems.hpp"

#include <gtest/gtest.h>

namespace roomfix {
namespace {

TEST(LineProblems, TheFirstAreToldAtOnceTheOthersAreCounted) {
    std::vector<std::string> told;
    LineProblems problems;
    problems.note({"nobody listens yet"}, 100);
    problems.on_problem([&](const std::string& problem) { told.push_back(problem); });
    problems.note({"line 3 has no time"}, 101);
    ASSERT_EQ(told, std::vector<std::string>{"line 3 has no time"});
    problems.note(std::vector<std::string>(1000, "nonsense"), 102);
    EXPECT_EQ(told.size(), 19U);
    problems.note({"nonsense"}, 170);
    ASSERT_EQ(told.size(), 21U);
    EXPECT_EQ(told[19], "982 more lines");
    EXPECT_EQ(told[20], "nonsense");
    problems.note(std::vector<std::string>(30, "nonsense"), 171);
    problems.finish();
    EXPECT_EQ(told.back(), "11 more lines");
    const std::size_t all = told.size();
    problems.finish();
    EXPECT_EQ(told.size(), all);
}

}  // namespace
}  // namespace roomfix
