// One explanation of a picture at a time: are these three edges there, and where exactly?
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "roomfix/corner/corner_settings.hpp"

namespace roomfix {

/// Three edges of a corner that a picture may show.
struct CornerExplanation {
    CornerFit fit;
    double wall_angle = 0;                    // rad
    double score = 0;                         // px of edges seen, less what is missing
    double doubt = 0;                         // what speaks against a camera that stands like this
    std::array<int, 3> lines = {-1, -1, -1};  // that led to it; -1: completed
    bool seen = false;                        // enough of its three lines, once they were fitted
    std::optional<CornerEdge> faint;          // an edge that may as well run elsewhere
};

EdgeKind other_than(EdgeKind kind);
const char* name_of(CornerEdge edge);

class CornerReader {
public:
    CornerReader(const CameraModel& model, const CornerSettings& settings);

    /// Scores, here and below: pixels of edge that the picture confirms, less what is missing; nothing if that is no corner.
    /// Reads a candidate's edges, the walls' one as a step or as a crease. `faintly`: pieces of an edge may be too faint one by one, as long as all of
    /// them together show it.
    std::optional<double> read(LumaView frame, const CornerCandidate& candidate, EdgeKind kind, bool faintly, CornerFit& fit);

    /// Fits an explanation to the end. `lines` of the picture; `second_look`: as what the walls' edge was not taken for, too.
    std::optional<double> refine(LumaView frame, const std::vector<SceneLine>& lines, bool second_look, CornerExplanation& explanation);

    /// The same from an explanation whose corner was lowered.
    std::optional<double> read_lowered(LumaView frame, const std::vector<SceneLine>& lines, CornerExplanation& lower);

    /// A corner expected where `fit.view` is, within `capture` px. No allocation if `fit` is reused.
    std::optional<double> find_again(LumaView frame, double wall_angle, double capture, EdgeKind kind, bool look_known, CornerFit& fit);

    /// Edges beside those of a fit that was fitted to the end, as a moulding draws them. No allocation after the first time.
    EdgesBeside beside(LumaView frame, double wall_angle, const CornerFit& fit);

    /// Another explanation, where the first does not hold. If that holds no better, why the first does not is what people want to know.
    template <class Explain>
    auto instead(const Explain& explain) {
        const std::string refusal = refusal_;
        auto found = explain();
        if (!found && !refusal.empty()) refusal_ = refusal;
        return found;
    }

    /// Why the last was no corner.
    const std::string& refusal() const { return refusal_; }
    void refuse(std::string why) { refusal_ = std::move(why); }

    const LightTable& light() const { return fitter_.light(); }
    const FaintEdges& faint_edges() const { return settler_.edges(); }
    const EdgeEnds& edge_ends() const { return edge_ends_; }

private:
    std::optional<double> refine_as_is(LumaView frame, const std::vector<SceneLine>& lines, CornerExplanation& explanation);
    std::optional<double> fit_to_the_end(LumaView frame, double wall_angle, CornerFit& fit);
    bool is_seen_enough(const CornerExplanation& explanation);
    bool is_deep_enough(LumaView frame, const CornerFit& fit) const;
    bool is_the_same(LumaView frame, const CornerView& beside, const CornerExplanation& explanation) const;
    bool fit_again(LumaView frame, double wall_angle, CornerFit& fit) const;
    std::optional<double> score_of(const CornerFit& fit, bool final_fit);
    void settle_height(LumaView frame, CornerExplanation& explanation);

    CameraModel model_;
    CornerSettings settings_;
    CornerFitter fitter_;
    EdgeEnds edge_ends_;
    EdgeSettler settler_;
    std::string refusal_;
    // Working memory.
    std::vector<ParallelCorner> parallels_;
    CornerFit around_;
};

}  // namespace roomfix
