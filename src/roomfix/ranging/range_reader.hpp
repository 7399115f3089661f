// Bytes from a listener or a file to range observations of a site. Nothing that comes in is believed unchecked.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "roomfix/observation/range_observation.hpp"
#include "roomfix/ranging/range_line.hpp"
#include "roomfix/site/site.hpp"

namespace roomfix {

struct RangeReaderSettings {
    double largest_range = 200;    // m: nothing indoors is farther
    double temperature_sigma = 2;  // degC, how well the air's temperature is known
    std::size_t longest_line = 512;
    double backwards = 1;  // s that a time may lie before the last one of the same beacon
};

/// What came out of some bytes.
struct RangeBatch {
    std::vector<RangeObservation> ranges;
    std::vector<RangeDifferenceObservation> differences;
    std::vector<std::string> problems;  // one sentence per line that was not used
    void clear();
};

/// Splits a byte stream into lines and reads each: CSV after a CSV header, JSON where a line starts with '{', Cricket otherwise.
/// Lines may come in pieces. A bad line costs itself only.
class RangeReader {
public:
    /// `robot` (index) is whose receiver this is, for lines that name no robot; -1: such lines are problems.
    /// `receiver` (index in the robot's receivers): likewise for lines that name no receiver.
    RangeReader(const Site& site, int robot, int receiver = 0, const RangeReaderSettings& settings = {});

    /// Appends to `batch`. `arrival` is the time for lines that state none; without it the listener's own clock must do.
    void feed(std::string_view bytes, std::optional<Nanoseconds> arrival, RangeBatch& batch);
    /// The last line of a file may lack its end.
    void finish(std::optional<Nanoseconds> arrival, RangeBatch& batch);

    long lines() const { return lines_; }
    long bad_lines() const { return bad_lines_; }

private:
    void take_line(std::string_view line, std::optional<Nanoseconds> arrival, RangeBatch& batch);
    Result<RangeLine> parse(std::string_view line);
    Result<void> add(const RangeLine& reading, std::optional<Nanoseconds> arrival, RangeBatch& batch);
    std::optional<int> robot_index(const std::string& name) const;
    std::optional<int> beacon_index(const std::string& name) const;

    std::vector<SiteRobot> robots_;
    std::vector<SiteBeacon> beacons_;
    double temperature_;
    int robot_, receiver_;
    RangeReaderSettings settings_;
    std::string partial_;
    bool oversized_ = false;
    std::optional<RangeColumns> columns_;
    std::vector<std::optional<Nanoseconds>> last_;  // per beacon
    long lines_ = 0;
    long bad_lines_ = 0;
};

}  // namespace roomfix
