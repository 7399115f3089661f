// A camera of which at most the height is known, on a site with tags as landmarks: its whole pose by the tags, and by a corner where it sees none.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "roomfix/ceiling/tag_locator.hpp"
#include "roomfix/imaging/tag_detector.hpp"
#include "roomfix/pipeline/camera/corner_camera.hpp"

namespace roomfix {

bool looks_for_tags(const Site& site, const SiteCamera& camera);

class TagCamera {
public:
    /// An error if it cannot read the site's tags, or if the site's corners do not fit together with what is said about the camera.
    static Result<TagCamera> create(const Site& site, const SiteCamera& camera);

    /// Index of the robot that is where the camera is, -1: none.
    int robot() const { return robot_; }
    void look(const PictureView& frame, const FrameHints& hints);
    Sighting sighting() const;
    Drawing drawing() const;

private:
    TagCamera(const Site& site, const SiteCamera& camera, std::optional<CornerCamera> corners);
    bool by_corner() const { return corners_ && located_.places.empty(); }
    std::string name_of_tag(const SeenTag& seen) const;
    double late(const TagCameraPlace& place) const;

    Site site_;
    CameraModel model_;
    double readout_;                                   // s
    std::vector<std::pair<Tag, TagPicture>> printed_;  // the site's tags as they are printed
    TagDetector detector_;
    TagLocator locator_;
    std::optional<CornerCamera> corners_;
    int robot_ = -1;
    // Of the last frame:
    std::vector<SeenTag> seen_;
    LocatedByTags located_;
};

}  // namespace roomfix
