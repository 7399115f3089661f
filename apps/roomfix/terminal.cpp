#include "terminal.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <fstream>
#include <memory>

namespace roomfix {

std::function<void(double)> progress_bar(const std::string& what) {
    if (!isatty(STDERR_FILENO)) return [](double) {};
    auto shown = std::make_shared<int>(-1);
    return [what, shown](double part) {
        const int percent = static_cast<int>(100 * std::clamp(part, 0.0, 1.0));
        if (percent == *shown || *shown == 100) return;
        *shown = percent;
        constexpr int width = 32;
        const auto full = static_cast<std::size_t>(percent * width / 100);
        fmt::print(stderr, "\r{} [{}{}] {:3} %", what, std::string(full, '='), std::string(width - full, ' '), percent);
        if (percent == 100) fmt::print(stderr, "\n");
        std::fflush(stderr);
    };
}

void say(const std::string& text) { fmt::print(stderr, "{}\n", text); }
void complain(const std::string& text) { fmt::print(stderr, "roomfix: {}\n", text); }

bool write_file(const std::filesystem::path& file, const std::string& text) {
    std::ofstream stream(file, std::ios::binary);
    stream << text;
    if (stream.flush()) return true;
    complain(file.string() + ": cannot be written: check that the folder exists");
    return false;
}

std::atomic<bool>& stop_requested() {
    static std::atomic<bool> stop = false;
    static const bool installed = [] {
        const auto handler = [](int number) {
            stop = true;
            std::signal(number, SIG_DFL);
        };
        std::signal(SIGINT, handler);
        std::signal(SIGTERM, handler);
        return true;
    }();
    (void)installed;
    return stop;
}

}  // namespace roomfix
