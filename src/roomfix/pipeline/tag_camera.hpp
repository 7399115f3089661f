// A camera that stands anywhere and sees tags, at work: from a frame to the camera's place, or to both that it may be.
#pragma once

#include <string>
#include <vector>

#include "roomfix/ceiling/tag_locator.hpp"
#include "roomfix/imaging/tag_detector.hpp"
#include "roomfix/observation/fix.hpp"

namespace roomfix {

/// What one frame shows, for the fix and for drawing.
struct TagCameraResult {
    std::vector<SeenTag> seen;
    LocatedByTags located;
};

/// A camera of which at most the height is known does, where the site has tags as landmarks.
bool looks_for_tags(const Site& site, const SiteCamera& camera);

class TagCamera {
public:
    TagCamera(const Site& site, const SiteCamera& camera);

    /// Index of the robot that is where the camera is, -1: none.
    int robot() const { return robot_; }
    /// Tags of the site are laid onto the picture as a whole, so that their corners are known to a few hundredths of a pixel.
    void look(LumaView frame, TagCameraResult& result);
    /// The landmark that a seen tag is; empty: none of the site.
    std::string name_of_tag(const SeenTag& seen) const;
    /// The result as a fix, with all places as hypotheses where there are several.
    Fix fix_of(const TagCameraResult& result, Nanoseconds time, const std::vector<std::string>& sources) const;

private:
    Site site_;
    CameraModel model_;
    std::vector<std::pair<Tag, TagPicture>> printed_;  // the site's tags as they are printed
    TagDetector detector_;
    TagLocator locator_;
    int robot_ = -1;
};

}  // namespace roomfix
