// How long each stage of a frame's way takes, from the camera to the fix.
#pragma once

#include <array>
#include <cstddef>
#include <mutex>
#include <string>

namespace roomfix {

enum class Stage {
    decode,   // a picture from its file or stream
    look,     // one camera: what is not background, outlines, tags, landmarks, corners
    fit,      // bodies in all cameras of a moment together
    track,    // the tracker takes in what was seen
    publish,  // fixes to the file and to the page
    moment,   // all of it but decoding, for all cameras that looked at about the same time
    latency,  // of fixes: from the frame's time until the fix was given, by the clock
};
constexpr std::size_t stages = 7;

const char* name_of(Stage stage);

/// Quantiles of a stage, s; good to 6 %.
struct StageSummary {
    long count = 0;
    double median = 0;
    double p95 = 0;
    double p99 = 0;
    double largest = 0;
};

/// From any thread.
class StageTimes {
public:
    void add(Stage stage, double seconds);
    StageSummary summary(Stage stage) const;
    /// Lines for a terminal: the stages that took any time, and a histogram of the latency, if it was measured, or of the moments.
    std::string text() const;

private:
    // Bins that grow by an eighth of an octave, from 10 us up.
    static constexpr std::size_t bins = 200;
    static constexpr double first_bin = 1e-5;  // s
    struct Histogram {
        std::array<long, bins> counts{};
        long count = 0;
        double largest = 0;
    };
    static std::size_t bin_of(double seconds);
    static double end_of(std::size_t bin);
    static double quantile(const Histogram& histogram, double part);
    std::string bars(Stage stage) const;

    mutable std::mutex mutex_;
    std::array<Histogram, stages> histograms_;
};

}  // namespace roomfix
