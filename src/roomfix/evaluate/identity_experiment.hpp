// Who is who, and where at all: robots that look the same crossing, four corners that look the same, robots carried away.
#pragma once

#include <cstdint>
#include <functional>

namespace roomfix {

struct CrossingResult {
    int crossings = 0;
    int switches = 0;      // a name followed the other robot two seconds after the crossing
    int flagged = 0;       // of these: `identity` was below 0.95 since
    int false_alarms = 0;  // crossings without a switch that end with a doubtful identity
    int lost = 0;          // a robot without a fix at the end
};

/// Two robots of the same look pass each other with their outlines overlapping by half, or turn back just there. One camera sees them at
/// 10 Hz; while they overlap, it sees them badly or only one of them.
CrossingResult simulate_crossings(int crossings, bool odometry, std::uint64_t seed);

/// The same from rendered pictures of one camera at the side of a hall: the robot behind is hidden by half while they pass. `overlap` gets
/// the mean part of its outline that was hidden at most. `progress` gets 0..1,
/// from several threads.
CrossingResult render_crossings(int crossings, bool odometry, std::uint64_t seed, double& overlap, const std::function<void(double)>& progress = {});

struct CornerChoiceResult {
    int runs = 0;
    int right_at_once = 0;  // the right corner at the first picture
    int right = 0;          // after two metres
};

/// A robot wakes up in a rectangular room whose four corners look the same; it drives two metres and hears one beacon.
CornerChoiceResult choose_among_corners(int runs, std::uint64_t seed);

struct KidnappingResult {
    int runs = 0;
    int found = 0;       // within two seconds of the first picture at the new place
    double longest = 0;  // s, of those found
};

/// A robot with odometry is carried away while nobody looks.
KidnappingResult simulate_kidnappings(int runs, std::uint64_t seed);

}  // namespace roomfix
