// Recorded ranges, odometry and sightings of a site's robots, in the order of their times.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "roomfix/connect/odometry_source.hpp"
#include "roomfix/connect/sighting_source.hpp"
#include "roomfix/ranging/range_reader.hpp"
#include "roomfix/site/site.hpp"

namespace roomfix {

/// Who is told what was recorded.
struct SenseListener {
    std::function<void(Nanoseconds)> goes_on;  // to the time of what is told next
    std::function<void(const RangeBatch&)> hears;
    std::function<void(const OdometryBatch&)> drives;
    std::function<void(const SightingBatch&)> detects;
};

/// What one robot sensed, each kind in the order of its times.
struct Senses {
    std::vector<RangeObservation> ranges;
    std::vector<RangeDifferenceObservation> differences;
    std::vector<SightingObservation> sightings;
    std::vector<OdometryObservation> odometry;

    bool empty() const { return ranges.empty() && differences.empty() && sightings.empty(); }
};

class RecordedSenses {
public:
    /// Reads all files that the site names, each once: one may hold the readings of several robots. An error names the file.
    static Result<RecordedSenses> load(const Site& site);

    /// Tells what lies between the last call's time and this one, as it would have come.
    void tell_until(Nanoseconds time, const SenseListener& listener);
    /// The time of what is told next; nothing at the end.
    std::optional<Nanoseconds> next_time() const;
    /// All that one robot sensed.
    Senses of(int robot) const;
    /// Before any of it was told: what this robot's wheels said cannot be used.
    void drop_odometry(int robot, const std::string& why);
    /// Lines that could not be used, as sentences.
    const std::vector<std::string>& problems() const { return problems_; }

private:
    RangeBatch ranges_;
    OdometryBatch odometry_;
    SightingBatch sightings_;
    std::size_t next_range_ = 0;  // the first that is still to be told
    std::size_t next_odometry_ = 0;
    std::size_t next_difference_ = 0;
    std::size_t next_sighting_ = 0;
    std::vector<std::string> problems_;
};

}  // namespace roomfix
