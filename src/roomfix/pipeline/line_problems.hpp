// What is wrong with lines that come from outside, for whoever runs the program.
#pragma once

#include <functional>
#include <mutex>
#include <string>
#include <vector>

namespace roomfix {

/// Tells the first problems of each while at once; the others are counted, so that a flood of nonsense fills no log. From any thread.
class LineProblems {
public:
    /// `listener` gets sentences; it is called with a lock held and must not come back here. Without one nothing is told.
    void on_problem(std::function<void(const std::string&)> listener);
    /// At `now`, s of any clock that only rises.
    void note(const std::vector<std::string>& problems, double now);
    /// At the end: how many were not told.
    void finish();

private:
    void tell_count();

    std::mutex mutex_;
    std::function<void(const std::string&)> listener_;
    double since_ = 0;  // s, of this while
    int told_ = 0;      // in it
    long held_ = 0;
};

}  // namespace roomfix
