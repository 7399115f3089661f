// What robots sensed as lines of a session's files, and those files read again.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "roomfix/base/result.hpp"
#include "roomfix/observation/odometry_observation.hpp"
#include "roomfix/observation/range_observation.hpp"
#include "roomfix/observation/sighting_observation.hpp"
#include "roomfix/site/site.hpp"

namespace roomfix {

/// First lines of ranges.csv (a file that has both kinds names its columns anew where they change), odometry.csv and sightings.csv.
constexpr std::string_view range_columns = "time,robot,beacon,range,sigma,receiver\n";
constexpr std::string_view range_difference_columns = "time,robot,beacon_a,beacon_b,difference,sigma,receiver\n";
constexpr std::string_view odometry_columns = "time,robot,x,y,yaw\n";
constexpr std::string_view sighting_columns = "time,robot,landmark,range,bearing,range_sigma,bearing_sigma\n";

/// One line with its end. Numbers read back to the same bits.
std::string sensed_line(const RangeObservation& range, const Site& site);
std::string sensed_line(const RangeDifferenceObservation& difference, const Site& site);
std::string sensed_line(const OdometryObservation& pose, const Site& site);
std::string sensed_line(const SightingObservation& sighting, const Site& site);

/// A file with this name lies in a session's folder as long as it is being recorded.
constexpr const char* unfinished_mark = "unfinished";

struct SensedText {
    std::string text;
    std::string note;  // what was left out of it, as a sentence; empty: nothing
};

/// A file of ranges, odometry or sightings. Of a recording that was cut off, the last line is left out where it has no end: half of a number is a number, too.
Result<SensedText> read_sensed(const std::filesystem::path& file);

}  // namespace roomfix
