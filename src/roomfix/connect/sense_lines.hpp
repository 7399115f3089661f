// Readings of robots' own senses as they come over the network: JSON lines.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "roomfix/connect/odometry_source.hpp"
#include "roomfix/connect/sender_clock.hpp"
#include "roomfix/connect/sighting_source.hpp"
#include "roomfix/ranging/range_reader.hpp"

namespace roomfix {

/// What some lines said.
struct Readings {
    RangeBatch ranges;
    OdometryBatch odometry;
    SightingBatch sightings;
};

/// Lines of one source. Each is a JSON object as in the files: with x, y, yaw a report of wheels; with a landmark or a bearing a sighting; else a range. Bad
/// lines cost themselves only. Each robot's clock is followed: times in what comes out are of our clock.
class SenseLines {
public:
    /// `source`: as the site file names it; lines without a robot are of the one that has this source.
    SenseLines(const Site& site, const std::string& source);

    /// Whole lines, which arrived at this time of our clock; `steady`: s of a clock that only goes forward. Lines without a time are as old as their arrival.
    Readings read(std::string_view lines, Nanoseconds arrival, double steady);
    /// Of each robot that sent something: how its clock differs, as a sentence.
    std::vector<std::string> clocks() const;

private:
    void read_line(std::string_view line, Nanoseconds arrival, Readings& readings);

    const Site& site_;
    int ranging_ = -1, driving_ = -1, detecting_ = -1;  // robots that have this source for that sense; -1: none or several
    int receiver_ = 0;
    RangeReader ranges_;
    std::map<int, SenderClock> clocks_;  // of each robot
};

}  // namespace roomfix
