// Notices that a fixed camera was turned since its background was taken.
#pragma once

#include "roomfix/geometry/view.hpp"
#include "roomfix/imaging/picture_alignment.hpp"

namespace roomfix {

struct BumpSettings {
    int every = 4;              // frames, one of which is looked at
    double sway = 0.5;          // px of the picture of at most 640 px: as EvidenceSettings::shift, by which the evidence may be off ...
    double beyond = 3;          // ... and so many times that is a camera that was moved
    double prior = 14;          // nats against it: bumped once in ten days, looked at once a second
    double most_turned = 0.1;   // rad, standard deviation of what somebody who bumps into a camera does to it
    double most_zoomed = 0.02;  // the same of its picture's size: a lens that is set anew
};

class BumpDetector {
public:
    explicit BumpDetector(const View& view, const BumpSettings& settings = {});

    /// The empty scene, as the camera saw it where it was calibrated.
    void set_reference(LumaView background);
    bool has_reference() const { return alignment_.has_reference(); }

    /// Looks at a frame of the reference's size if it is time to. True if the camera was moved, as far as is known.
    bool is_bumped(LumaView frame);

    /// Of the last frame looked at: how far the picture lies off, px, root mean square.
    double offset() const { return found_.offset; }
    /// The angle by which the camera was turned, rad.
    double turned() const { return found_.motion.head<3>().norm(); }

private:
    MotionJacobian jacobian_at(const Eigen::Vector2d& pixel) const;

    CameraModel model_;
    BumpSettings settings_;
    PictureAlignment alignment_;
    Alignment found_;
    bool bumped_ = false;
    int frames_ = 0;
};

}  // namespace roomfix
