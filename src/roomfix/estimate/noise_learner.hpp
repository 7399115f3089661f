// How a robot's senses really err, from how well they agree with each other while it drives.
#pragma once

#include <optional>
#include <vector>

#include "roomfix/estimate/noise_search.hpp"
#include "roomfix/estimate/track.hpp"

namespace roomfix {

/// Keeps what a robot sensed lately. Now and then, ever more rarely, it looks for the noise under which all of that is most likely: the density of each
/// observation before it was taken, by the tracker itself, multiplied (prediction error decomposition). One number after the other is doubled, halved, ...
class NoiseLearner {
public:
    /// Is it this track's, since it was started?
    bool follows(const Track& track) const { return begun_ && origin_.born == track.born && origin_.belief.placed() == track.belief.placed(); }
    void begin(const Track& track);
    void add(const Event& event);
    /// The time of the oldest odometry that is needed.
    Nanoseconds reach() const;

    /// Is it time to learn from all events up to `until`?
    bool due(Nanoseconds until) const;
    /// The track after all events up to `until`, as the noise makes it that was learned.
    Track learn(Nanoseconds until, const TrackingModels& models);

private:
    double evidence(const Track& origin, const SenseNoise& noise, std::size_t count, const TrackingModels& models, Track* end) const;
    /// Where the track may have been instead when it was started, with the noise under which that is likeliest.
    struct Rival {
        Track track;
        NoiseSearch::Result result;
    };
    std::vector<Rival> compare_rivals(NoiseSearch::Result& found, const SensedKinds& kinds, std::size_t count, const TrackingModels& models);
    Eigen::Matrix3d doubt_of(const Track& end, double log_density, const std::vector<Rival>& rivals, std::size_t count, const TrackingModels& models) const;
    std::vector<Track> rivals(std::size_t count, const TrackingModels& models) const;
    std::vector<Track> rivals_anywhere(std::size_t count, const TrackingModels& models) const;
    std::vector<PlaceProposal> likely_places(std::vector<PlaceProposal> places, const Heard& heard, std::size_t count, bool depth,
                                             const TrackingModels& models) const;
    void forget(std::size_t count, const TrackingModels& models);
    void find_what_is_new(std::size_t count, const TrackingModels& models);

    bool begun_ = false;
    Track origin_;                      // before all events, with the likeliest noise
    SenseNoise first_noise_;            // the origin's, before anything was learned
    SenseNoise noise_;                  // as it was learned last
    bool learned_once_ = false;         // since the origin
    std::optional<SenseNoise> before_;  // as it was learned before the track was put elsewhere
    std::vector<Event> events_;         // in their order
    std::vector<bool> news_;            // which of them say something new
    double wait_ = 0;                   // s from the origin's start until it is due
    Nanoseconds learned_ = 0;
};

}  // namespace roomfix
