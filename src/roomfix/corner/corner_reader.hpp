// One explanation of a picture at a time: are these three edges there, and where exactly?
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "roomfix/base/result.hpp"
#include "roomfix/corner/corner_settings.hpp"

namespace roomfix {

/// Three edges of a corner that a picture may show.
struct CornerExplanation {
    CornerFit fit;
    double wall_angle = 0;                           // rad
    double score = 0;                                // px of edges seen, less what is missing
    double doubt = 0;                                // what speaks against a camera that stands like this
    std::array<int, 3> lines = {-1, -1, -1};         // that led to it; -1: completed
    bool seen = false;                               // enough of its three lines, once they were fitted
    bool completed() const { return lines[2] < 0; }  // two lines led to it, the third was looked for in the picture
    std::optional<CornerEdge> faint;                 // an edge that may as well run elsewhere
};

EdgeKind other_than(EdgeKind kind);
/// Why neither of two readings holds: people want to know about the first, if that says anything.
inline const Error& first_reason(const Error& first, const Error& second) { return first.message.empty() ? second : first; }
const char* name_of(CornerEdge edge);

class CornerReader {
public:
    CornerReader(const CameraModel& model, const CornerSettings& settings);

    /// Scores, here and below: pixels of edge that the picture confirms, less what is missing; an error that says why if that is no corner, without words
    /// where there is nothing to say.
    /// Reads a candidate's edges, the walls' one as a step or as a crease. `faintly`: pieces of an edge may be too faint one by one, as long as all of
    /// them together show it.
    Result<double> read(LumaView frame, const CornerCandidate& candidate, EdgeKind kind, bool faintly, CornerFit& fit);

    /// Fits an explanation to the end. `lines` of the picture. `second_look`: also with a crease between the walls where a step was read, or a step where
    /// a crease was; the better one counts.
    Result<double> refine(LumaView frame, const std::vector<SceneLine>& lines, bool second_look, CornerExplanation& explanation);

    /// The same from an explanation whose corner was lowered.
    Result<double> read_lowered(LumaView frame, const std::vector<SceneLine>& lines, CornerExplanation& lower);

    /// A corner expected where `fit.view` is, within `capture` px. No allocation if `fit` is reused.
    Result<double> find_again(LumaView frame, double wall_angle, double capture, EdgeKind kind, bool look_known, CornerFit& fit);

    /// Edges beside those of a fit that was fitted to the end, as a moulding draws them. No allocation after the first time.
    EdgesBeside beside(LumaView frame, double wall_angle, const CornerFit& fit);

    const LightTable& light() const { return fitter_.light(); }
    const FaintEdges& faint_edges() const { return settler_.edges(); }
    const EdgeEnds& edge_ends() const { return edge_ends_; }

private:
    Result<double> refine_as_is(LumaView frame, const std::vector<SceneLine>& lines, CornerExplanation& explanation);
    Result<double> fit_to_the_end(LumaView frame, double wall_angle, CornerFit& fit);
    Result<void> is_seen_enough(const CornerExplanation& explanation) const;
    bool is_deep_enough(LumaView frame, const CornerFit& fit) const;
    bool is_the_same(LumaView frame, const CornerView& beside, const CornerExplanation& explanation) const;
    bool fit_again(LumaView frame, double wall_angle, CornerFit& fit) const;
    Result<double> score_of(const CornerFit& fit, bool final_fit) const;
    void settle_height(LumaView frame, CornerExplanation& explanation);

    CameraModel model_;
    CornerSettings settings_;
    CornerFitter fitter_;
    EdgeEnds edge_ends_;
    EdgeSettler settler_;
    // Working memory.
    std::vector<ParallelCorner> parallels_;
    CornerFit around_;
};

}  // namespace roomfix
