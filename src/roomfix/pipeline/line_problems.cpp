#include "roomfix/pipeline/line_problems.hpp"

#include <fmt/format.h>

#include <utility>

namespace roomfix {
namespace {

constexpr double a_while = 60;  // s
constexpr int most_told = 20;   // in a while

}  // namespace

void LineProblems::on_problem(std::function<void(const std::string&)> listener) {
    const std::lock_guard lock(mutex_);
    listener_ = std::move(listener);
}

void LineProblems::note(const std::vector<std::string>& problems, double now) {
    if (problems.empty()) return;
    const std::lock_guard lock(mutex_);
    if (now - since_ > a_while) {
        tell_count();
        since_ = now;
        told_ = 0;
    }
    for (const std::string& problem : problems) {
        if (told_ >= most_told) {
            ++held_;
            continue;
        }
        ++told_;
        if (listener_) listener_(problem);
    }
}

void LineProblems::finish() {
    const std::lock_guard lock(mutex_);
    tell_count();
}

/// The mutex is held.
void LineProblems::tell_count() {
    if (held_ > 0 && listener_) listener_(fmt::format("{} more lines", held_));
    held_ = 0;
}

}  // namespace roomfix
