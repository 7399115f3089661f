// Shows a fixed camera's pictures as it would have taken them had nobody bumped into it.
#pragma once

#include <optional>

#include "roomfix/base/time.hpp"
#include "roomfix/imaging/colour_image.hpp"
#include "roomfix/imaging/picture_alignment.hpp"

namespace roomfix {

struct StabiliserSettings {
    double prior = 14;       // nats against a camera that was moved: once in ten days, looked at once a second
    double showing = 0.3;    // part of what has structure that must show the reference: another scene does in up to 0.16 of it by chance
    double least = 0.35;     // px of the picture shrunk to at most 640 px, of which it may be off: ColourBackground allows for 0.5
    double moved = 1.5;      // px of it, beyond which the camera was bumped and does not just sway
    double interval = 0.35;  // s between two pictures whose place is looked for
};

class PictureStabiliser {
public:
    explicit PictureStabiliser(const CameraModel& model, const StabiliserSettings& settings = {}) : alignment_(model), settings_(settings) {}

    /// The scene as the camera saw it where it was calibrated, best without robots; of the camera's size. What a moved camera does not see is taken from it.
    void set_reference(const PictureView& reference);
    bool has_reference() const { return alignment_.has_reference(); }

    /// The frame as the camera would have seen it from where it took the reference: itself, or memory of this stabiliser until the next call. Frames have
    /// the reference's size. Without `time` each one is looked at for itself. No allocation in steady state.
    PictureView steady(const PictureView& frame, std::optional<Nanoseconds> time = std::nullopt);

    // Of the last frame that was looked at:

    /// The camera was moved since the reference was taken.
    bool moved() const { return turned_back_ && offset() > settings_.moved * colour_scale(alignment_.model().width); }
    /// How far its picture lies off, px, root mean square.
    double offset() const { return found_.offset; }
    /// The angle by which the camera was turned, rad.
    double turned() const { return found_.motion.head<3>().norm(); }

private:
    /// Grey or colours, interleaved, that somebody else owns.
    struct Plane {
        const std::uint8_t* values;
        int width, height;
        std::ptrdiff_t stride;  // bytes from row to row
    };
    void find_sources();
    template <int Channels>
    void turn_back(const Plane& frame, const Plane& reference, int scale, std::uint8_t* to, std::ptrdiff_t stride) const;
    void turn_back(LumaView frame);
    void turn_back(const ColourImage& frame);

    PictureAlignment alignment_;
    StabiliserSettings settings_;
    LumaImage reference_;
    ColourImage reference_colour_;
    Alignment found_;
    bool turned_back_ = false;
    std::optional<Nanoseconds> looked_;
    std::vector<Eigen::Vector2f> grid_;  // where in the frame every 16th pixel of every 16th row of the reference is seen
    LumaImage grey_;
    ColourImage colour_;
};

}  // namespace roomfix
