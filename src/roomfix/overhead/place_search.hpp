// Where is a robot of which only a part is seen? Looks at all the floor under the foreground, lets the outlines decide, and says
// how sure that is.
#pragma once

#include <vector>

#include "roomfix/overhead/foreground_border.hpp"
#include "roomfix/overhead/outline_fit.hpp"
#include "roomfix/overhead/outline_search.hpp"
#include "roomfix/overhead/robot_search.hpp"

namespace roomfix {

struct PlaceSearchSettings {
    int most_glances = 160;         // places where the outline is fitted in a hurry
    int most_fits = 24;             // of these, fitted in full
    double missing_cost = 1.5;      // of the score, per area of the silhouette of certain foreground left outside
    double unexplained_cost = 0.7;  // of the score, for a border of which nothing is explained
    double doubt = 0.05;            // of the score: rivals worse by this are e times less likely
};

/// Keeps its memory between searches.
class PlaceSearch {
public:
    struct Result {
        OutlineFit fit;     // its covariance is that of all places together, each weighted by how likely it is
        CoarsePose coarse;  // the same place judged by its area
    };

    /// The best place for a body of this shape to explain the blob; a fit that is not determined if there is none. `guess`
    /// is looked at as well.
    Result find(const FrameEvidence& evidence, const ForegroundMasks& masks, const View& view, const ShapePoints& shape, const Blob& blob, const Pose2& guess,
                const OutlineFitSettings& fit, const PlaceSearchSettings& settings);

private:
    struct Rival {
        Pose2 pose;
        Eigen::Matrix3d covariance;
        double quality = 0;
    };
    void glance(const FrameEvidence& evidence, const View& view, const ShapePoints& shape, const OutlineFitSettings& fit, const PlaceSearchSettings& settings);
    Pose2 mean_near(const Rival& best, const ShapePoints& shape, double doubt) const;
    Eigen::Matrix3d covariance_around(const Rival& best, const ShapePoints& shape, double doubt) const;

    ForegroundBorder border_;
    BorderDistance border_distance_;
    std::vector<OutlineStart> starts_;
    std::vector<OutlineStart> glances_;
    std::vector<Rival> rivals_;
};

}  // namespace roomfix
