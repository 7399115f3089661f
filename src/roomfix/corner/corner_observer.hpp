// A camera sees a room's corner: from a frame to the corner, or to all that it may be.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "roomfix/corner/corner_reader.hpp"
#include "roomfix/corner/corner_search.hpp"
#include "roomfix/corner/line_search.hpp"
#include "roomfix/imaging/edge_points.hpp"
#include "roomfix/observation/corner_observation.hpp"

namespace roomfix {

/// What is known besides the picture.
struct CornerHints {
    struct Expected {
        CornerView view;
        double wall_angle = std::numbers::pi / 2;
        double sigma = 3;  // px, of where the edges are expected
    };
    std::vector<Expected> expected;  // from a prediction: looked for first, and nothing else if one of them is there
    std::optional<Gravity> gravity;
};

/// A line of the picture that belongs to no corner, px.
struct RejectedLine {
    Eigen::Vector2f from = Eigen::Vector2f::Zero(), to = Eigen::Vector2f::Zero();
};

struct CornerResult {
    std::vector<CornerObservation> corners;  // the likeliest sighting first, as it was read; weights add up to 1
    std::vector<RejectedLine> rejected;
    bool predicted = false;  // found where it was expected
    std::string reason;      // why there is none; empty otherwise
};

class CornerObserver {
public:
    /// `wall_angles`: the angles between walls that the site's corners have, rad. Frames must have the model's size.
    CornerObserver(const CameraModel& model, const std::vector<double>& wall_angles, const CornerSettings& settings = {});

    /// No allocation in steady state where a corner is found at its expected place, as long as `result` is reused.
    void observe(LumaView frame, const CornerHints& hints, CornerResult& result);

private:
    bool look_where_expected(LumaView frame, const CornerHints& hints, CornerResult& result);
    void look_everywhere(LumaView frame, const CornerHints& hints, CornerResult& result);
    Result<void> try_candidate(LumaView frame, const CornerHints& hints, const CornerCandidate& candidate, bool faintly);
    Result<void> explain(LumaView frame, const CornerHints& hints, CornerResult& result);
    std::string reason_for_nothing(std::size_t triples, const Error& refusal) const;
    void sort_explanations();
    Result<void> refine_best(LumaView frame);
    void report(LumaView frame, CornerResult& result);
    void add_readings(const CornerFit& fit, double wall_angle, const EdgesBeside& beside, double weight, CornerResult& result) const;
    void merge_same();
    double doubt_of(const CornerView& view, double wall_angle, const CornerHints& hints) const;
    bool ends_at(LumaView frame, const CornerExplanation& lower, const CornerExplanation& upper) const;
    void drop_upper_ones(LumaView frame);
    bool go_down(LumaView frame, CornerExplanation& upper);
    CornerObservation observation_of(const CornerFit& fit, double wall_angle) const;
    void add_rejected(const std::array<int, 3>& used, CornerResult& result) const;

    CameraModel model_;
    CornerSettings settings_;
    EdgePointFinder finder_;
    LineSearch line_search_;
    CornerSearch search_;
    CornerReader reader_;
    // Working memory, kept between frames.
    std::vector<EdgePoint> points_;
    std::vector<SceneLine> lines_;
    CornerSearchResult found_;
    std::vector<CornerExplanation> explanations_;
    CornerFit fit_;
    EdgesBeside beside_;                                            // the edges of fit_, as seen ...
    Eigen::Vector2d beside_from_ = Eigen::Vector2d::Constant(1e9);  // ... from this place
};

}  // namespace roomfix
