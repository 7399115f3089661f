// How well the colours in one camera's picture agree with the learned look of a body at a pose.
#pragma once

#include <vector>

#include "roomfix/geometry/view.hpp"
#include "roomfix/imaging/evidence.hpp"
#include "roomfix/site/learned_body.hpp"

namespace roomfix {

struct LookSettings {
    double otherwise = 0.15;       // part of the spots that are hidden, or look as never before
    double light_sigma = 0.2;      // log: how far the light on the robot may differ from the light on the floor behind it
    double contrast_sigma = 0.25;  // how far the contrast of log colours may differ: tone curves, black levels, haze
    double facing = 0.2;           // cosine between a spot's direction and the camera's: flatter ones are not compared
    double usual_clutter = 0.8;    // part of the pixels that show something else where looks of different places are compared
    int least_spots = 12;          // in view: fewer say nothing
};

/// A spot in a picture.
struct SeenSpot {
    std::size_t spot = 0;   // of the look
    std::size_t pixel = 0;  // of the evidence
};

/// The spots that face the camera and lie in its picture; of every `step`-th. Returns how many face it, in the picture or not.
int see_spots(const View& view, const Evidence& evidence, const BodyLook& look, const Pose2& pose, const LookSettings& settings, std::vector<SeenSpot>& seen,
              std::size_t step = 1);

struct LookScore {
    double per_spot = 0;  // nats: log ratio of the look's probability to that of background and of things of any colour, mean over the spots
                          // that face the camera; those beside the picture say nothing
    int spots = 0;        // that face it
    int seen = 0;         // those in the picture
};

/// `clutter`: part of the pixels around that show something else. The evidence must have its colours.
LookScore score_look(const View& view, const Evidence& evidence, const BodyLook& look, const Pose2& pose, double clutter, const LookSettings& settings,
                     std::vector<SeenSpot>& seen, std::size_t step = 1);

/// Log odds that a thing whose agreement is `per_spot` (nats) is the robot and no clutter, both being as frequent. Source: two Student
/// distributions of four degrees of freedom, since few moments taught their widths; better than usual counts as usual.
double log_odds_of_look(const LearnedBody& body, double per_spot);

/// What another light makes of a body's log colours: all brighter or darker, and farther from each other or closer.
struct ToneChange {
    double light = 0;     // added
    double contrast = 0;  // added, times how far a colour is from `middle`
    double middle = 0;    // log colour

    double of(double colour) const { return light + contrast * (colour - middle); }
    /// The colour that is seen like this.
    double undone(double seen) const { return middle + (seen - light - middle) / (1 + contrast); }
};

/// By how much what is seen of the spots differs from how they look. The contrast is held near the usual one as `settings` say.
ToneChange tone_on(const Evidence& evidence, const BodyLook& look, const std::vector<SeenSpot>& seen, const LookSettings& settings);

}  // namespace roomfix
