// Where a camera stands that sees tags: all six degrees of freedom, from all tags of a picture together.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "roomfix/imaging/tag_detector.hpp"
#include "roomfix/site/site.hpp"

namespace roomfix {

struct TagLocatorSettings {
    double another_tag = 45;     // chi-square of a tag's eight coordinates: beyond, it hangs elsewhere or was misread
    double unexplained = 12;     // nats that such a tag costs a place
    double least_weight = 1e-3;  // of a place
    double same_place = 0.01;    // m and rad: nearer than this, two fits are one place
    int most_rounds = 30;
};

/// One place where the camera may be.
struct TagCameraPlace {
    UncertainPose3 map_from_camera;
    double weight = 1;
    double chi_square = 0;
    std::vector<int> tags;  // indices of the seen tags that it explains
};

struct LocatedByTags {
    std::vector<TagCameraPlace> places;  // the likeliest first; weights add up to 1
    std::string reason;                  // why there is none
};

class TagLocator {
public:
    /// `camera` says at most how high it is: any of its other placements is not looked at.
    TagLocator(const Site& site, const SiteCamera& camera, const TagLocatorSettings& settings = {});

    /// Every tag alone allows up to two poses (a plane seen from afar looks nearly the same when it tilts the other way); each is a
    /// start of the fit to all tags, to how they may hang, and to the camera's height. Covariances hold the noise of the corners, the
    /// tags' places and turns, and the intrinsics.
    void locate(std::span<const SeenTag> seen, LocatedByTags& result) const;

private:
    struct Linearised;
    struct Fit;
    std::vector<Eigen::Isometry3d> starts(const SeenTag& seen, const SiteLandmark& tag) const;
    const SiteLandmark* landmark_of(const SeenTag& seen) const;
    std::optional<Linearised> linearise(std::span<const SeenTag> seen, const std::vector<int>& used, const Eigen::Isometry3d& map_from_camera) const;
    std::optional<Fit> fit(std::span<const SeenTag> seen, const std::vector<int>& used, Eigen::Isometry3d map_from_camera) const;
    std::optional<TagCameraPlace> settle(std::span<const SeenTag> seen, const std::vector<int>& known, const Eigen::Isometry3d& start) const;

    std::vector<SiteLandmark> landmarks_;
    CameraModel model_;
    IntrinsicsMatrix intrinsics_;
    std::optional<KnownHeight> height_;
    TagLocatorSettings settings_;
};

}  // namespace roomfix
