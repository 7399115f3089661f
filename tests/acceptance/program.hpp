// The program called as its users call it.
#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <string>

namespace roomfix {

struct Outcome {
    int code;
    std::string text;  // stdout and stderr
};

inline Outcome call(const std::string& arguments) {
    FILE* pipe = popen((std::string(ROOMFIX_PROGRAM) + " " + arguments + " 2>&1").c_str(), "r");
    std::array<char, 4096> buffer;
    Outcome outcome{-1, ""};
    while (const auto size = std::fread(buffer.data(), 1, buffer.size(), pipe)) outcome.text.append(buffer.data(), size);
    const int status = pclose(pipe);
    outcome.code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    return outcome;
}

inline void expect_says(const Outcome& outcome, int code, const std::string& words) {
    EXPECT_EQ(outcome.code, code) << outcome.text;
    EXPECT_NE(outcome.text.find(words), std::string::npos) << outcome.text;
}

}  // namespace roomfix
