#include "roomfix/pipeline/stage_times.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace roomfix {

const char* name_of(Stage stage) {
    static constexpr std::array<const char*, stages> names = {"decode", "look", "fit", "track", "publish", "moment", "latency"};
    return names[static_cast<std::size_t>(stage)];
}

std::size_t StageTimes::bin_of(double seconds) {
    if (!(seconds > first_bin)) return 0;
    return std::min(static_cast<std::size_t>(8 * std::log2(seconds / first_bin)), bins - 1);
}

double StageTimes::end_of(std::size_t bin) { return first_bin * std::exp2(static_cast<double>(bin + 1) / 8); }

void StageTimes::add(Stage stage, double seconds) {
    const std::lock_guard lock(mutex_);
    Histogram& histogram = histograms_[static_cast<std::size_t>(stage)];
    ++histogram.counts[bin_of(seconds)];
    ++histogram.count;
    histogram.largest = std::max(histogram.largest, seconds);
}

double StageTimes::quantile(const Histogram& histogram, double part) {
    const auto wanted = static_cast<long>(std::ceil(part * static_cast<double>(histogram.count)));
    long seen = 0;
    for (std::size_t bin = 0; bin < bins; ++bin) {
        seen += histogram.counts[bin];
        if (seen >= wanted) return std::min(end_of(bin), histogram.largest);
    }
    return histogram.largest;
}

StageSummary StageTimes::summary(Stage stage) const {
    const std::lock_guard lock(mutex_);
    const Histogram& histogram = histograms_[static_cast<std::size_t>(stage)];
    if (histogram.count == 0) return {};
    return {histogram.count, quantile(histogram, 0.5), quantile(histogram, 0.95), quantile(histogram, 0.99), histogram.largest};
}

std::string StageTimes::text() const {
    std::string text = fmt::format("{:>8} {:>8} {:>10} {:>10} {:>10} {:>10}\n", "ms", "count", "median", "95 %", "99 %", "largest");
    for (std::size_t s = 0; s < stages; ++s) {
        const StageSummary stage = summary(static_cast<Stage>(s));
        if (stage.count == 0) continue;
        text += fmt::format("{:>8} {:>8} {:>10.2f} {:>10.2f} {:>10.2f} {:>10.2f}\n", name_of(static_cast<Stage>(s)), stage.count, 1e3 * stage.median,
                            1e3 * stage.p95, 1e3 * stage.p99, 1e3 * stage.largest);
    }
    return text + bars(summary(Stage::latency).count > 0 ? Stage::latency : Stage::moment);
}

/// One line for every half octave.
std::string StageTimes::bars(Stage stage) const {
    constexpr std::size_t bins_per_line = 4;
    constexpr double widest = 40;  // characters
    const std::lock_guard lock(mutex_);
    const Histogram& histogram = histograms_[static_cast<std::size_t>(stage)];
    std::array<long, bins / bins_per_line> lines{};
    for (std::size_t bin = 0; bin < bins; ++bin) lines[bin / bins_per_line] += histogram.counts[bin];
    const long most = *std::max_element(lines.begin(), lines.end());
    if (most == 0) return {};
    std::size_t first = 0;
    std::size_t last = lines.size();
    while (lines[first] == 0) ++first;
    while (lines[last - 1] == 0) --last;
    std::string text = fmt::format("{} in ms:\n", name_of(stage));
    for (std::size_t line = first; line < last; ++line) {
        const auto length = static_cast<int>(std::ceil(widest * static_cast<double>(lines[line]) / static_cast<double>(most)));
        text += fmt::format("{:>9.1f} {:>7} {}\n", 1e3 * end_of(line * bins_per_line + bins_per_line - 1), lines[line],
                            std::string(static_cast<std::size_t>(length), '#'));
    }
    return text;
}

}  // namespace roomfix
